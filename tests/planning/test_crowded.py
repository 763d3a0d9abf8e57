"""First scenes for robots whose links are in each other's way in most postures."""

import math

import pytest

from horosphere import robots
from horosphere.errors import InputError
from horosphere.planning import plan, starter_scene
from horosphere.planning._sampled import clearances


def turntable(folder, blocked):
    """A ball that goes round on a disc, among balls that stand at the `blocked` angles."""

    def ball(x, y):
        return f'<collision><origin xyz="{x} {y} 0"/><geometry><sphere radius="0.05"/></geometry></collision>'

    ring = "".join(ball(0.5 * math.cos(angle), 0.5 * math.sin(angle)) for angle in blocked)
    limit = '<axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>'
    text = f'<robot name="turntable"><link name="a">{ring}</link><link name="b"/><link name="c">{ball(0, 0)}</link>'
    text += f'<joint name="j" type="revolute"><parent link="a"/><child link="b"/>{limit}'
    text += f'<joint name="k" type="revolute"><parent link="b"/><child link="c"/><origin xyz="0.5 0 0"/>{limit}</robot>'
    path = folder / "turntable.urdf"
    path.write_text(text)
    return robots.load(path)


@pytest.mark.parametrize("seed", range(3))
def test_a_tenth_of_the_postures_is_enough(tmp_path, seed):
    angles = [0.1 * k for k in range(-17, 18)]
    robot = turntable(tmp_path, [angle for angle in angles if abs(angle - 0.9) > 0.34])
    scene = starter_scene(robot, "turntable", seed)
    assert all(clearances(robot, target.q[None], ())[1][0] > 0.0 for target in (scene.start, scene.goal))
    assert all(abs(target.q[0] - 0.9) < 0.2 for target in (scene.start, scene.goal))
    assert plan(scene, improvement_time=0.0).solved


def test_no_posture_at_all_is_said(tmp_path):
    robot = turntable(tmp_path, [0.1 * k for k in range(-17, 18)])
    with pytest.raises(InputError, match=r"postures are free of contact.*its notes name the links"):
        starter_scene(robot, "turntable")
