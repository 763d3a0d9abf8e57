"""Random robots, and the same robots in pinocchio."""

from pathlib import Path

import numpy as np


def random_urdf(seed: int, path: Path) -> str:
    """Write a random tree: a chain of all kinds of joints, with side branches. Returns the tip."""
    rng = np.random.default_rng(seed)
    kinds = ["revolute", "continuous", "prismatic", "fixed", "revolute", "mimic", "prismatic", "revolute"]
    rng.shuffle(kinds)
    text, masters = ['<robot name="random"><link name="l0"/>'], []

    def joint(name, kind, parent, child, mimic=""):
        xyz, rpy, axis = rng.normal(size=3) * 0.3, rng.uniform(-3, 3, 3), rng.normal(size=3)
        words = [" ".join(f"{v:.17g}" for v in values) for values in (xyz, rpy, axis)]
        limit = "" if kind in ("fixed", "continuous") else '<limit lower="-1.5" upper="1.2" velocity="2" effort="3"/>'
        text.append(
            f'<link name="{child}"/><joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{words[0]}" rpy="{words[1]}"/><axis xyz="{words[2]}"/>{limit}{mimic}</joint>'
        )

    for k, kind in enumerate(kinds):
        mimic = ""
        if kind == "mimic":
            kind = "revolute"
            if masters:
                mimic = f'<mimic joint="{rng.choice(masters)}" multiplier="-0.6" offset="0.1"/>'
        elif kind != "fixed":
            masters.append(f"j{k}")
        joint(f"j{k}", kind, f"l{k}", f"l{k + 1}", mimic)
    joint("side", "revolute", "l4", "s1")  # beside the chain: locked at zero
    joint("follower", "revolute", "l3", "s2", f'<mimic joint="{masters[0]}" multiplier="2.0" offset="-0.3"/>')
    path.write_text("".join(text) + "</robot>")
    return f"l{len(kinds)}"


class Pinocchio:
    """A URDF in pinocchio, posed with the joint values of one of our robots."""

    def __init__(self, path: Path, robot, base: str | None = None) -> None:
        import pinocchio as pin

        self.pin, self.robot = pin, robot
        self.model = pin.buildModelFromUrdf(str(path))
        self.data = self.model.createData()
        self.base = base or robot.link_names[0]
        self.mimics = {}
        from lxml import etree

        for element in etree.parse(str(path)).getroot().iterfind("joint"):
            mimic = element.find("mimic")
            if mimic is not None:
                entry = (mimic.get("joint"), float(mimic.get("multiplier", 1)), float(mimic.get("offset", 0)))
                self.mimics[element.get("name")] = entry

    def value(self, name, q):
        """Value of a joint: (coordinate, d value / d coordinate, value); coordinate -1 if it stands still."""
        if name in self.robot.joint_names:
            c = self.robot.joint_names.index(name)
            return c, 1.0, q[c]
        if name in self.mimics:
            master, multiplier, offset = self.mimics[name]
            c, rate, value = self.value(master, q)
            return c, rate * multiplier, multiplier * value + offset
        j = self.model.getJointId(name)
        if self.model.joints[j].nq == 2:
            return -1, 0.0, 0.0
        k = self.model.joints[j].idx_q
        return -1, 0.0, float(np.clip(0.0, self.model.lowerPositionLimit[k], self.model.upperPositionLimit[k]))

    def pose(self, q):
        """All our link frames (links, 4, 4) and their Jacobians (links, 6, n), angular first, at the frame, base axes."""
        pin, model, data = self.pin, self.model, self.data
        configuration = pin.neutral(model)
        rates = np.zeros((model.nv, self.robot.n_joints))
        for j, name in enumerate(model.names):
            if name == "universe":
                continue
            c, rate, value = self.value(name, q)
            joint = model.joints[j]
            if joint.nq == 2:
                configuration[joint.idx_q : joint.idx_q + 2] = np.cos(value), np.sin(value)
            else:
                configuration[joint.idx_q] = value
            if c >= 0:
                rates[joint.idx_v, c] = rate
        pin.computeJointJacobians(model, data, configuration)
        pin.updateFramePlacements(model, data)
        base = data.oMf[model.getFrameId(self.base, pin.FrameType.BODY)]
        frames, jacobians = [], []
        turn = base.rotation.T
        for name in self.robot.link_names:
            frame = model.getFrameId(name, pin.FrameType.BODY)
            frames.append((base.inverse() * data.oMf[frame]).homogeneous)
            J = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED) @ rates
            jacobians.append(np.vstack([turn @ J[3:], turn @ J[:3]]))
        return np.array(frames), np.array(jacobians)


def random_q(robot, rng, shape=()):
    """Joint values within the limits (a few turns where there are none)."""
    low, high = np.clip(robot.limits.lower, -7.0, 7.0), np.clip(robot.limits.upper, -7.0, 7.0)
    return rng.uniform(low, high, (*shape, robot.n_joints))
