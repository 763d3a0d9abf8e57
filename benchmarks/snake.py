"""Snake robots: speed of the model, exact growth vectors, steering and navigation on random problems.

python benchmarks/snake.py model
python benchmarks/snake.py growth
python benchmarks/snake.py steer [M] [SEED]  M problems (40) for each number of links, |dq| log-uniform from 0.01 to 1
python benchmarks/snake.py navigate [M]      M random worlds (100), 6 links, 8 discs in 60 m x 40 m
"""

from __future__ import annotations

import sys
import time
from collections import Counter

import numpy as np
from _harness import compare, heading

from horosphere.snake import Snake, Surroundings


def plain_model(q, lengths):
    """Joints, Pfaff matrix and control basis by plain numpy, one posture, as a user would write it."""
    links = len(lengths)
    th = np.cumsum(q[2:])
    d = np.stack([np.cos(th), np.sin(th)], 1)
    joints = np.vstack([q[:2], q[:2] + np.cumsum(lengths[:, None] * d, 0)])
    centres = joints[:-1] + 0.5 * lengths[:, None] * d
    pfaff = np.zeros((links - 2, links + 2))
    basis = np.zeros((links + 2, 4))
    u, before = np.eye(2), np.zeros(2)
    basis[0, 0] = basis[1, 1] = 1.0
    for i in range(1, links - 1):
        n = np.array([-d[i, 1], d[i, 0]])
        arms = centres[i] - joints[: i + 1]
        pfaff[i - 1, :2] = n
        pfaff[i - 1, 2 : 3 + i] = -n[0] * arms[:, 1] + n[1] * arms[:, 0]
        rate = -(n @ u) * 2 / lengths[i]
        basis[2 + i, :2] = rate - before
        before = rate
        u = np.outer(d[i], d[i] @ u) - np.outer(n, n @ u)
    basis[:4, 2] = lengths[0] * np.sin(th[0]), -lengths[0] * np.cos(th[0]), 1.0, -1.0
    basis[-1, 3] = 1.0
    return joints, pfaff, basis


def model() -> None:
    snake = Snake(8)
    rng = np.random.default_rng(0)
    q = rng.uniform(-3, 3, snake.n)
    batch = rng.uniform(-3, 3, (4096, snake.n))
    one, many = snake.model(q), snake.model(batch)
    for part, expected in zip(snake.split_model(one), plain_model(q, snake.lengths)):
        assert np.abs(part - expected).max() < 1e-12
    compare(
        "N = 7: joints + Pfaff matrix + control basis, one posture",
        {
            "horosphere, out=": lambda: snake.model(q, out=one),
            "horosphere": lambda: snake.model(q),
            "plain numpy": lambda: plain_model(q, snake.lengths),
        },
    )
    compare(
        "the same, 4096 postures, an item",
        {
            "horosphere, out=": lambda: snake.model(batch, out=many),
            "plain numpy, looped": lambda: [plain_model(p, snake.lengths) for p in batch],
        },
        items=4096,
        rounds=5,
    )


def growth() -> None:
    rng = np.random.default_rng(0)
    print(
        f"\n{'N':>3} {'growth vector':36s} {'spectral, exact':>16s} {'words, 2 fields':>16s} {'words, 4 fields':>16s}"
    )
    for N in range(2, 13):
        snake = Snake(N + 1)
        q = np.concatenate([rng.uniform(-1, 1, 3), rng.uniform(-2, 2, N)])
        row = []
        for options in ({"method": "spectral"}, {"method": "words"}, {"method": "words", "fields": 4}):
            if N > 10 and options.get("fields") == 4:
                row.append("-")
                continue
            started = time.perf_counter()
            found = snake.growth(q, **options)
            row.append(f"{(time.perf_counter() - started) * 1e3:.1f} ms" + ("" if found.complete else " (not full)"))
        print(f"{N:3d} {snake.growth(q).vector!s:36s} {row[0]:>16s} {row[1]:>16s} {row[2]:>16s}")


def steer(count: int, first: int) -> None:
    for links in range(5, 10):
        snake = Snake(links)
        seconds, lengths, errors, failures = [], [], [], Counter()
        for index in range(count):
            rng = np.random.default_rng(first + 1000 * links + index)
            distance = 10.0 ** rng.uniform(-2.0, 0.0)
            q0 = np.concatenate([rng.uniform(-1, 1, 3), rng.uniform(-1.2, 1.2, links - 1)])
            way = rng.normal(size=snake.n)
            started = time.perf_counter()
            result = snake.steer(q0, q0 + distance * way / np.linalg.norm(way))
            seconds.append(time.perf_counter() - started)
            if result.solved:
                lengths.append(result.path_length)
                errors.append(result.error)
            else:
                failures[result.reason.split(";")[0]] += 1
        print(
            f"N = {links - 1}: {count - failures.total()}/{count} solved, "
            f"median {np.median(seconds):.3f} s, slowest {max(seconds):.2f} s, "
            f"way of joint 1 median {np.median(lengths or [np.nan]):.1f} m, "
            f"largest error {max(errors or [np.nan]):.1e}; {dict(failures)}",
            flush=True,
        )


def world(seed: int, snake: Snake, discs: int = 8):
    """Start on the left, goal on the right of 60 m x 40 m, discs of 1 to 3.5 m with gaps of at least 3 m between them."""
    rng = np.random.default_rng(seed)

    def posture(x: float) -> np.ndarray:
        q = np.concatenate([[0.0, 0.0, np.pi + rng.uniform(-0.3, 0.3)], rng.uniform(-0.3, 0.3, snake.links - 1)])
        q[:2] += np.array([x, rng.uniform(12, 28)]) - snake.joints(q)[0]
        return q

    q0, q1 = posture(rng.uniform(12, 16)), posture(rng.uniform(52, 55))
    centers, radii = [], []
    for _ in range(2000):
        if len(centers) == discs:
            break
        p, r = rng.uniform([5, 3], [56, 37]), rng.uniform(1.0, 3.5)
        disc = Surroundings(p[None], np.array([r]), None, None, ())
        near = min(disc.of_body(snake.joints(q0), 0.05), disc.of_body(snake.joints(q1), 0.05))
        if near > 1.0 and all(np.hypot(*(p - c)) > r + s + 3.0 for c, s in zip(centers, radii)):
            centers.append(p)
            radii.append(r)
    return q0, q1, (np.array(centers), np.array(radii))


def navigate(count: int) -> None:
    snake = Snake(6)
    classes, seconds, clearances = Counter(), [], []
    for seed in range(count):
        q0, q1, obstacles = world(seed, snake)
        started = time.perf_counter()
        result = snake.navigate(q0, q1, obstacles, workspace=([0.0, 0.0], [60.0, 40.0]))
        seconds.append(time.perf_counter() - started)
        classes[result.failure or "solved"] += 1
        if result.solved:
            clearances.append(result.certificate.clearance)
            assert result.certificate.certified and result.error < 1e-6
        else:
            print(f"  world {seed}: {result.reason}")
    print(
        f"{count} worlds: {dict(classes)}; median {np.median(seconds):.2f} s, slowest {max(seconds):.1f} s; "
        f"certified clearance from {min(clearances):.2f} m, median {np.median(clearances):.2f} m"
    )


if __name__ == "__main__":
    heading()
    what = sys.argv[1] if len(sys.argv) > 1 else "model"
    number = int(sys.argv[2]) if len(sys.argv) > 2 else None
    if what == "model":
        model()
    elif what == "growth":
        growth()
    elif what == "steer":
        steer(number or 40, int(sys.argv[3]) if len(sys.argv) > 3 else 9000)
    elif what == "navigate":
        navigate(number or 100)
    else:
        sys.exit(f"unknown benchmark {what!r}; valid: model, growth, steer, navigate")
