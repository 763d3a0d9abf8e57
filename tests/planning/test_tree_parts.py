"""The pieces of the tree planner, each against plain numpy: frames, solids, covers, motion and rounding bounds."""

import numpy as np
import pytest

from horosphere import robots
from horosphere.kernels import EIGHT, jit
from horosphere.planning import _edge_kernels as edge
from horosphere.planning import _world_kernels as world
from horosphere.planning._tree import Search
from horosphere.planning._tree_model import body_pairs, cover, enclosing_ball, moving_frames, position_error, spans
from horosphere.planning._tree_room import halton
from horosphere.planning._tree_space import Space
from horosphere.planning._world import solid_rows
from horosphere.robots._placement import link_frames, move_points, rotation_translation
from horosphere.shapes import Ball, Box, Capsule, Cylinder, Ellipsoid, HalfSpace

from .test_tree import furniture, gantry_with_two_arms, made

NAMES = ["panda", "ur5", "nao-left-arm", "gantry"]


def packed(robot, obstacles=(), start=None, fineness=1e-3):
    start = np.zeros(robot.n_joints) if start is None else start
    return Space(Search(robot, start, start[None], tuple(obstacles), 0.0, 0.0, 0), fineness).pack()


def placed(space, q, v, t):
    """Frames at q + t v as the planner computes them, (16, F, 3, 4): axes as columns, and the origin."""
    joints, data = space.model.arrays[:2]
    frames = space.scratch[0]
    lanes = np.float32(t)
    place_all(np.float32(q), np.float32(v), lanes, joints, data, frames)
    return frames.reshape(len(joints), 4, 3, 16).transpose(3, 0, 2, 1).astype(np.float64)


def place_all(q, v, t, joints, data, frames):
    from horosphere.kernels import jit, load_lanes

    global _placer
    if _placer is None:

        @jit
        def placer(q, v, t, joints, data, frames):
            edge.place_frames(q, v, load_lanes(t, 0, edge.LANES), joints, data, frames)

        _placer = placer
    _placer(q, v, t, joints, data, frames)


_placer = None


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("name", NAMES)
def test_frames_and_their_rounding(name, seed):
    """Every ball centre lies within the derived rounding bound of the numpy reference, and not absurdly far inside it."""
    robot, rng = made(name), np.random.default_rng(seed)
    space = packed(robot)
    frames, balls = space.model.frames, space.model.balls
    low, high = np.clip(robot.limits.lower, -3, 3), np.clip(robot.limits.upper, -3, 3)
    root, span, lever = spans(frames, balls, low, high)
    bound = position_error(frames, lever, span, root, low, high)
    worst = 0.0
    for _ in range(20):
        q, goal = rng.uniform(low, high, (2, robot.n_joints))
        t = np.float32(np.sort(rng.uniform(size=16)))
        v = np.float32(goal * space.model.weight) - np.float32(q * space.model.weight)
        ours = placed(space, q * space.model.weight, v, t)
        exact = q + np.float64(t)[:, None] * (goal - q)
        links = link_frames(robot.links, exact)
        for frame, first, last in balls.bodies:
            link = int(np.flatnonzero(frames.of_link == frame)[0])
            inverse = np.linalg.inv(frames.in_frame[link])
            for a, b in balls.groups[first:last]:
                centres = balls.balls[a:b, :3]
                there = move_points(links[:, link, None], centres @ inverse[:3, :3].T + inverse[:3, 3])
                here = np.einsum("tij,mj->tmi", ours[:, frame, :, :3], centres) + ours[:, frame, None, :, 3]
                worst = max(worst, float(np.linalg.norm(there - here, axis=2).max()))
    assert 0.0 < worst < bound < 2e-4
    assert worst > bound / 300


SOLIDS = {
    "ball": lambda rng, R: Ball(rng.normal(size=3), 0.3),
    "capsule": lambda rng, R: Capsule(rng.normal(size=3), rng.normal(size=3), 0.2),
    "cylinder": lambda rng, R: Cylinder(rng.normal(size=3), rng.normal(size=3), 0.4),
    "box": lambda rng, R: Box(rng.normal(size=3), rng.uniform(0.1, 1, 3), R),
    "upright box": lambda rng, R: Box(rng.normal(size=3), rng.uniform(0.1, 1, 3), upright(rng)),
    "box on its side": lambda rng, R: Box(rng.normal(size=3), rng.uniform(0.1, 1, 3), upright(rng)[:, [1, 2, 0]]),
    "half-space": lambda rng, R: HalfSpace(R[:, 0], rng.normal()),
    "ellipsoid": lambda rng, R: Ellipsoid(rng.normal(size=3), rng.uniform(0.1, 1, 3), R),
}


def upright(rng):
    a = rng.uniform(-3, 3)
    return np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1.0]])


@jit
def sort(m, margin, scene, lists):
    return world.sort_solids(m, margin, scene, lists)


def sorted_solids(solids, spans, margin):
    """The lists of `world`, cut to what is in them, `reach`, and the largest coordinate, for a root in the origin."""
    rows, spans = solid_rows(solids).copy(), np.array(spans)
    m = len(rows)
    memory = np.zeros(m), np.zeros(m, np.int64), np.zeros(m, np.int64), np.zeros(5, np.int64)
    lists = tuple(np.zeros((m, width), np.float32) for width in (8, 16, 8, 8, 16))
    reach = np.full((len(spans), 10), 7)
    extent = sort(m, margin, (rows, np.zeros(3), spans, np.zeros((0, 0), np.uint8), *memory), (*lists, reach))
    return *(x[:k] for x, k in zip(lists, memory[3])), reach, extent


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", SOLIDS)
def test_squares_of_distances(kind, seed):
    """Packed and evaluated on numpy's reference back end, against the shape's own signed distance."""
    rng = np.random.default_rng(seed)
    R = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    R[:, 0] *= np.sign(np.linalg.det(R))
    solid = SOLIDS[kind](rng, R)
    lists = sorted_solids([solid], [4.0, 0.0], 0.01)
    points = rng.uniform(-2, 2, (400, 3))
    squares = (
        world.upright_square,
        world.box_square,
        world.cylinder_square,
        world.segment_square,
        world.ellipsoid_square,
    )
    found = [(f, rows) for f, rows in zip(squares, lists[:5]) if len(rows)]
    assert len(found) == 1 and lists[5][0].sum() == 1
    square, rows = found[0]
    row = rows[0].astype(np.float64)
    distance = np.sqrt(square.reference(points, row)[:, 0])
    if kind in ("ball", "capsule"):
        distance = np.maximum(distance - row[7], 0.0)
    exact = np.maximum(solid.signed_distance(points), 0.0)
    if kind != "ellipsoid":
        np.testing.assert_allclose(distance, exact, atol=3e-6)
        return
    assert (distance <= exact + 1e-6).all()  # never more than the truth, and near it
    assert (distance >= 0.9 * exact - 1e-3).all() and np.mean(distance >= 0.99 * exact - 1e-3) > 0.9


def test_solids_out_of_reach_are_dropped():
    solids = [Ball([0.5, 0, 0], 0.1), Ball([3.0, 0, 0], 0.1), Box([0, 9, 0], [1, 1, 1]), Ball([0.9, 0, 0], 0.1)]
    *lists, reach, extent = sorted_solids(solids, [1.0, 0.6], 0.0)
    assert [len(x) for x in lists] == [0, 0, 0, 2, 0]
    assert reach[:, :5].tolist() == [[0, 0, 0, 2, 0], [0, 0, 0, 1, 0]] and not reach[:, 5:].any()
    assert extent < 1.2


@pytest.mark.parametrize("name", NAMES)
def test_cover_holds_every_capsule(name):
    robot, rng = made(name), np.random.default_rng(0)
    frames = moving_frames(robot)
    for fineness in (2e-3, 2e-4):
        balls = cover(robot, frames, fineness)
        assert balls.inflation <= fineness * (1 + 1e-9)
        bodies = robot.capsules
        for k in range(len(bodies)):
            t, u = rng.uniform(-0.2, 1.2, 300).clip(0, 1)[:, None], rng.normal(size=(300, 3))
            surface = bodies.a[k] + t * (bodies.b[k] - bodies.a[k])
            surface += bodies.radius[k] * u / np.linalg.norm(u, axis=1, keepdims=True)
            link = bodies.link[k]
            inside = surface @ frames.in_frame[link][:3, :3].T + frames.in_frame[link][:3, 3]
            own = np.concatenate([balls.balls[a:b] for (a, b), l in zip(balls.groups, balls.links) if l == link])
            gap = np.linalg.norm(inside[:, None] - own[:, :3], axis=2) - own[:, 3]
            assert gap.min(axis=1).max() < 1e-9
        for (a, b), bound in zip(balls.groups, balls.bounds):
            part = balls.balls[a:b]
            assert (np.linalg.norm(part[:, :3] - bound[:3], axis=1) + part[:, 3] <= bound[3] + 1e-12).all()


def test_enclosing_ball_is_small():
    rng = np.random.default_rng(0)
    on_sphere = rng.normal(size=(200, 3))
    on_sphere /= np.linalg.norm(on_sphere, axis=1, keepdims=True)
    ball = enclosing_ball(np.column_stack([on_sphere + [1, 2, 3], np.full(200, 0.1)]))
    assert 1.0 < ball[3] < 1.2
    np.testing.assert_array_equal(enclosing_ball(np.array([[1.0, 2, 3, 0.5]])), [1, 2, 3, 0.5])


@pytest.mark.parametrize("name", NAMES)
def test_no_point_moves_further_than_its_bound(name):
    """Random boxes of configurations, random members of them, against the numpy frames."""
    from horosphere.kernels import load_lanes, store_lanes

    @jit
    def bound_of(f, stop, point, q, v, t, half, joints, data, frames, packet, out):
        edge.place_frames(q, v, load_lanes(t, 0, edge.LANES), joints, data, frames)
        x, y, z = edge._carried(
            *edge.load_columns(frames, 12 * 16 * f, 12, edge.LANES), point[0], point[1], point[2], 0.0
        )
        lanes = load_lanes(half, 0, edge.LANES)
        store_lanes(out, 0, edge.motion_bound(f, stop, x, y, z, lanes, v, packet))

    robot, rng = made(name), np.random.default_rng(0)
    space = packed(robot)
    joints, data = space.model.arrays[:2]
    frames = space.model.frames
    largest = 0.0
    for _ in range(60):
        link = int(rng.choice(np.flatnonzero(frames.of_link > 0)))
        f = int(frames.of_link[link])
        q, v = rng.uniform(-1.5, 1.5, robot.n_joints), rng.normal(size=robot.n_joints) * rng.choice([0.02, 0.2])
        t, half, out = np.full(16, 0.3, np.float32), np.full(16, 0.5, np.float32), np.zeros(16, np.float32)
        local = rng.normal(size=3) * 0.1
        here = frames.in_frame[link][:3, :3] @ local + frames.in_frame[link][:3, 3]
        weight = space.model.weight
        bound_of(
            f,
            0,
            np.float32(here),
            np.float32(q),
            np.float32(v),
            t,
            half,
            joints,
            data,
            space.scratch[0],
            space.packet,
            out,
        )
        middle = q + 0.3 * v
        others = middle + 0.5 * v * rng.choice([-1.0, 1.0, 0.3], size=(64, robot.n_joints))  # a box, not a segment
        moved = move_points(link_frames(robot.links, others / weight)[:, link], local)
        moved = moved - move_points(link_frames(robot.links, middle / weight)[link], local)
        ratio = np.linalg.norm(moved, axis=1).max() / out[0]
        assert ratio <= 1.0 + 1e-4
        largest = max(largest, ratio)
    assert largest > 0.5  # and the bound is of the right size


def test_edges_against_dense_sampling():
    """Certified clear edges are clear; contacts are contacts; most of what is clear gets certified."""
    from horosphere.planning._packet_kernels import check_edge

    from ._dense import clearances

    @jit
    def check(packet, q, v, count, how, margin, self_margin):
        return check_edge(packet, q, v, np.int64(count), np.int64(how), margin, self_margin)

    robot, rng = made("panda"), np.random.default_rng(3)
    obstacles = [o for o in furniture(rng, 14) if not isinstance(o, Ellipsoid)]
    space = packed(robot, obstacles)
    tally = {-1: 0, 0: 0, 1: 0}
    for _ in range(60):
        q = rng.uniform(robot.limits.lower, robot.limits.upper)
        v = np.float32(rng.normal(size=7) * 0.3)
        q = np.float32(q)
        margins = space.margins(0.0, 0.0)
        answer = check(space.packet, q, v, 16, edge.CERTIFIED, *margins)
        sampled = check(space.packet, q, v, 2, edge.SAMPLED, *margins)
        path = np.float64(q) + np.linspace(0, 1, 200)[:, None] * np.float64(v)
        outer, inner = clearances(robot, path, obstacles)
        least = min(outer.min(), inner.min())
        tally[answer] += 1
        if answer == edge.CLEAR:
            assert least > 0.0 and sampled == edge.CLEAR
        if answer == edge.CONTACT:
            assert least < 2.0 * space.uncertainty + 3e-3  # the cover of the capsules stands out by up to 1 mm
        if least > 5e-3:
            assert answer == edge.CLEAR
    assert tally[1] > 10 and tally[-1] > 10


def test_pairs_are_those_of_the_robot():
    robot = gantry_with_two_arms()
    frames = moving_frames(robot)
    balls = cover(robot, frames, 1e-3)
    pairs, groups = body_pairs(robot, frames, balls)
    seen = {tuple(sorted((int(balls.links[a]), int(balls.links[b])))) for a, b in groups}
    assert seen == {(2, 4), (2, 5), (3, 4), (3, 5)}
    assert (pairs[:, 2] == 1).all()  # the cart carries both arms
    assert pairs[-1, 4] == len(groups)


def test_halton_fills_the_cube():
    points = halton(500, 9)
    assert ((points > 0) & (points < 1)).all()
    np.testing.assert_allclose(points[:4, 0], [1 / 3, 2 / 3, 1 / 9, 4 / 9])
    assert abs(points.mean() - 0.5) < 0.02


def test_motor_matrices_agree():
    """`moving_frames` turns each frame so that its joint's axis is z: at zero all links stand where the reference has them."""
    for name in NAMES:
        robot = made(name)
        frames = moving_frames(robot)
        space = packed(robot)
        ours = placed(space, np.zeros(robot.n_joints), np.zeros(robot.n_joints), np.zeros(16))[0]
        rotation, translation = rotation_translation(link_frames(robot.links, np.zeros(robot.n_joints)))
        for link, f in enumerate(frames.of_link):
            pose = np.vstack([ours[f], [0, 0, 0, 1]]) @ frames.in_frame[link]
            np.testing.assert_allclose(pose[:3, :3], rotation[link], atol=1e-6)
            np.testing.assert_allclose(pose[:3, 3], translation[link], atol=1e-6)
    assert len(EIGHT) == 8 and robots.names()
