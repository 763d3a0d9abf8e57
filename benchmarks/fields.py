# ruff: noqa: B023, E501
"""Harmonic fields: speed, random worlds, peers, tracking.

python benchmarks/fields.py speed
python benchmarks/fields.py worlds [N [FAMILY]] N worlds a family (1000), every sampling period from 0.01 to 1 in turn
python benchmarks/fields.py peers [N [FAMILIES [METHODS]]]  N worlds a family (100) for ours, plain-numpy references and, if installed, cbfpy
python benchmarks/fields.py fabrics [N]         N worlds of discs (100) for the package fabrics, in its own environment (_fabrics_peer.py)
python benchmarks/fields.py tracking [N]        N worlds (60), periods 1, 5, 20, 50 ms, |u| <= 4, disturbance 0.3
"""

from __future__ import annotations

import importlib.util
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time
from collections import Counter
from functools import partial

import numpy as np
from _field_peers import cbf, cbfpy, modulation, navigation, simulate
from _harness import heading

from horosphere import control
from horosphere.fields import HarmonicField, random_world
from horosphere.fields._random_worlds import FAMILIES, as_stars

PERIODS = (0.01, 0.03, 0.1, 0.3, 1.0)


def best(f, repeats=7):
    f()
    times = []
    for _ in range(repeats):
        t = time.perf_counter()
        f()
        times.append(time.perf_counter() - t)
    return min(times)


def numpy_batch(points, goal, centers, radii, charges, boundary):
    """The same field in vectorised numpy, as a user would write it (nearby pairs by a mask)."""
    y = points[:, None] - centers
    r = np.linalg.norm(y, axis=-1)
    d = r - radii
    out = np.empty_like(points)
    away = goal - points
    r2 = (away**2).sum(-1)
    least = d.min(1)
    w = np.zeros_like(d)
    near = d < least[:, None] + 2 * boundary
    single = near.sum(1) == 1
    w[single] = near[single]
    for k in np.flatnonzero(~single):
        i = np.flatnonzero(near[k])
        gap = np.linalg.norm(centers[i][:, None] - centers[i], axis=-1) - radii[i][:, None] - radii[i]
        t = np.clip(
            0.5 + 0.5 * (d[k, i][None] - d[k, i][:, None]) / np.minimum(boundary, np.where(gap > 0, gap, 1.0)), 0, 1
        )
        h = t**3 * (10 + t * (6 * t - 15))
        np.fill_diagonal(h, 1.0)
        v = h.prod(1)
        w[k, i] = v / v.sum()
    out = away + ((w * charges * r2[:, None] / r**2)[..., None] * y).sum(1)
    return out / np.linalg.norm(out, axis=-1, keepdims=True)


def scatter(count, seed=0):
    rng = np.random.default_rng(seed)
    side = 2.2 * count ** (1 / 3)
    centers, radii = [], []
    while len(centers) < count:
        c, r = rng.uniform(0, side, 3), rng.uniform(0.2, 0.6)
        if not centers or (np.linalg.norm(np.array(centers) - c, axis=1) - radii - r).min() > 0.03:
            centers.append(c)
            radii.append(r)
    return np.full(3, side + 1.0), np.array(centers), np.array(radii), side


def speed():
    print(
        "| balls in R^3 | one evaluation inside compiled code, us | indexed, us | index, MB | made in, s of CPU | numpy batch, us a point | ratio "
        "| call from Python, us |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for count in (10, 100, 1000, 10_000, 100_000):
        goal, centers, radii, side = scatter(count) if count <= 1000 else lattice(count)
        field = HarmonicField(goal, (centers, radii), boundary=0.2)
        x = np.random.default_rng(1).uniform(0, side, (10_000, 3))
        few = x if count <= 1000 else x[:200].copy()
        ours = best(lambda: field.world.scaled(few)) / len(few) * 1e6
        field.indexed()
        begin = time.process_time()
        fast = field.indexed()
        made = f"{fast.world.index.bytes / 1e6:.1f} | {time.process_time() - begin:.2f}"
        index = best(lambda: fast.world.scaled(x)) / len(x) * 1e6
        plain, ratio = "", ""
        if count <= 1000:
            part = x[: 10_000 if count <= 100 else 1000]
            plain_us = (
                best(lambda: numpy_batch(part, goal, centers, radii, field.world.charges, 0.2), 3) / len(part) * 1e6
            )
            np.testing.assert_allclose(
                numpy_batch(part, goal, centers, radii, field.world.charges, 0.2), field(part), atol=1e-9
            )
            plain, ratio = f"{plain_us:.1f}", f"{plain_us / ours:.0f}x"
        one = x[:1].copy()
        call = best(lambda: [field(one[0]) for _ in range(100)]) / 100 * 1e6
        print(f"| {len(radii)} | {ours:.2f} | {index:.2f} | {made} | {plain} | {ratio} | {call:.1f} |", flush=True)
    world = random_world("balls", 1)
    field = HarmonicField(world.goal, world.obstacles)
    step = np.linalg.norm(world.goal - world.start) / 470
    path = field.trace(world.start, step=step)
    print(
        f"\ntrace of {len(path.points)} points among 60 balls: {best(lambda: field.trace(world.start, step=step)) * 1e3:.2f} ms"
    )
    print(f"its field built in {best(lambda: HarmonicField(world.goal, world.obstacles)) * 1e3:.2f} ms")


def lattice(count):
    side = round(count ** (1 / 3))
    rng = np.random.default_rng(0)
    grid = 1.6 * np.stack(np.meshgrid(*[np.arange(float(side))] * 3), axis=-1).reshape(-1, 3)
    return (
        np.full(3, -2.0),
        grid + rng.uniform(-0.3, 0.3, grid.shape),
        rng.uniform(0.2, 0.45, len(grid)),
        1.6 * (side - 1),
    )


def worlds(count, families=FAMILIES):
    print(
        "| family | worlds | reached | touched | moved away | not certified | least clearance, m | path / straight | build, ms | trace, ms |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|")
    for family in families:
        tally, least, ratios, built, traced = Counter(), np.inf, [], 0.0, 0.0
        for seed in range(count):
            world = random_world(family, seed)
            t0 = time.perf_counter()
            field = HarmonicField(world.goal, world.obstacles)
            t1 = time.perf_counter()
            path = field.trace(world.start, step=PERIODS[seed % 5])
            t2 = time.perf_counter()
            built, traced = built + t1 - t0, traced + t2 - t1
            away = np.linalg.norm(field.chart.to_balls(path.points) - field.world.goal, axis=1)
            tally["reached"] += path.reached
            tally["away"] += bool(np.diff(away).max() > 1e-9)
            tally["open"] += not field.certificate().granted
            dense = np.concatenate(
                [path.points[:-1] + t * np.diff(path.points, axis=0) for t in (0.0, 0.25, 0.5, 0.75)]
            )
            if isinstance(world.obstacles, tuple):
                level = min(np.linalg.norm(dense - c, axis=1).min() - r for c, r in zip(*world.obstacles))
            else:
                level = min(star.level(dense).min() for star in world.obstacles)
            tally["touched"] += bool(level < 0.0)
            least = min(least, path.clearance)
            ratios.append(path.length / np.linalg.norm(world.start - world.goal))
        print(
            f"| {family} | {count} | {tally['reached']} | {tally['touched']} | {tally['away']} | {tally['open']} | {least:.2g} | "
            f"{np.mean(ratios):.3f} | {built / count * 1e3:.1f} | {traced / count * 1e3:.1f} |",
            flush=True,
        )


def peers(count, families="discs,balls,flat-ellipses,lobed-stars,plates", names=""):
    """Ours takes clipped steps of 0.03 m, the others explicit ones of 0.01 m; `count` worlds a family."""
    print("| family | method | reached | touched | path / straight | median clearance, m | us an evaluation |")
    print("|---|---|---|---|---|---|---|")
    for family in families.split(","):
        methods = {"ours": None, "modulation": modulation, "cbf": cbf}
        if importlib.util.find_spec("cbfpy"):
            methods["cbfpy"] = cbfpy
        if family in ("discs", "balls"):
            methods |= {f"navigation k={k}": partial(navigation, k=float(k)) for k in (5, 30)}
        for name in names.split(",") if names else methods:
            if name not in methods:
                continue
            make, rows = methods[name], []
            for seed in range(count):
                world = random_world(family, seed)
                stars = as_stars(world)
                straight = np.linalg.norm(world.start - world.goal)
                if make is None:
                    field = HarmonicField(world.goal, world.obstacles)
                    path = field.trace(world.start, step=0.03)
                    least = min(float(star.distance(path.points).min()) for star in stars)
                    t = time.perf_counter()
                    for x in path.points[:50]:
                        field(x)
                    rows.append(
                        (
                            path.reached,
                            least < 0.0,
                            path.length / straight,
                            least,
                            (time.perf_counter() - t) / min(50, len(path.points)),
                        )
                    )
                else:
                    f = make(world.goal, stars)
                    ok, hit, length, least, spent = simulate(
                        f, world.start, world.goal, stars, unit=not name.startswith("cbf")
                    )
                    rows.append((ok, hit, length / straight, least, spent))
            table = np.array(rows, float)
            good = table[(table[:, 0] > 0) & (table[:, 1] == 0)]
            ratio, clear = (good[:, 2].mean(), np.median(good[:, 3])) if len(good) else (np.nan, np.nan)
            print(
                f"| {family} | {name} | {len(good)}/{count} | {int(table[:, 1].sum())} | {ratio:.3f} | {clear:.2g} | {np.median(table[:, 4]) * 1e6:.0f} |",
                flush=True,
            )


def fabrics(count):
    """The package `fabrics` on the discs, in the environment that FABRICS_PYTHON names (see _fabrics_peer.py)."""
    with tempfile.TemporaryDirectory() as folder:
        worlds = [random_world("discs", seed) for seed in range(count)]
        np.savez(
            f"{folder}/worlds.npz",
            start=[w.start for w in worlds],
            goal=[w.goal for w in worlds],
            centers=[w.obstacles[0] for w in worlds],
            radii=[w.obstacles[1] for w in worlds],
        )
        script = pathlib.Path(__file__).with_name("_fabrics_peer.py")
        out = subprocess.run(
            [os.environ["FABRICS_PYTHON"], script, f"{folder}/worlds.npz"], check=True, capture_output=True, text=True
        )
    rows = [json.loads(line) for line in out.stdout.splitlines() if line.startswith("{")]
    runs = rows[1:]
    good = [r for r in runs if r["reached"] and r["clearance"] >= 0.0]
    print(
        f"fabrics, {count} discs worlds: reached {len(good)}, touched {sum(r['clearance'] < 0.0 for r in runs)}, path / straight "
        f"{np.mean([r['ratio'] for r in good]):.3f}, median clearance {np.median([r['clearance'] for r in good]):.2g} m, "
        f"{np.median([r['us'] for r in runs]):.0f} us an evaluation, built in {rows[0]['build']:.2f} s"
    )


def tracking(count, laws=()):
    """60 discs worlds; "used" is how far a run went into the margin, "covered" whether `tracking_inflation` is at least that."""
    print(
        "| law | period, ms | worlds | reached | collisions | least clearance, mm | rms of s, mm/s | TV(u), m/s^3 | margin used, mm | inflation computed, mm | covered |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    speed = control.SpeedProfile(braking=1.6, lateral=1.6)
    choices = {
        "implicit + feedforward (default)": ("implicit-unit-vector", {}),
        "implicit": ("implicit-unit-vector", {"feedforward": False}),
        "explicit": ("explicit", {}),
        "boundary layer 0.1 m/s": ("boundary-layer", {}),
        "super-twisting": ("super-twisting", {}),
    }
    for name in laws or choices:
        law, options = choices[name]
        for period in (0.001, 0.005, 0.02, 0.05):
            rows = []
            for seed in range(count):
                world = random_world("discs", seed)
                centers, radii = world.obstacles
                gaps = np.linalg.norm(centers[:, None] - centers, axis=-1) - radii[:, None] - radii
                np.fill_diagonal(gaps, np.inf)
                ends = [0.5 * (np.linalg.norm(centers - p, axis=1) - radii).min() for p in (world.start, world.goal)]
                margin = min(0.05, 0.4 * gaps.min(), *ends)
                field = HarmonicField(world.goal, world.obstacles, margin=margin)
                run = control.track(
                    field,
                    world.start,
                    world.goal,
                    period=period,
                    law=control.SlidingMode(4.0, law, **options),
                    speed=speed,
                    disturbance=0.3,
                    clearance=lambda x, c=centers, r=radii: (np.linalg.norm(x[:, None] - c, axis=2) - r).min(1),
                )
                near = np.linalg.norm(run.positions[:, None] - centers, axis=2) - radii
                k = int(np.unravel_index(near.argmin(), near.shape)[1])
                away = float(np.linalg.norm(centers[k] - world.goal))
                used = max(0.0, margin - run.clearance)
                need = float(control.tracking_inflation(radii[k], away, speed, run.worst_error(nearer=margin)))
                rows.append(
                    (
                        run.reached,
                        run.clearance < 0.0,
                        run.clearance,
                        run.rms_error(1.0),
                        run.total_variation(),
                        used,
                        need,
                    )
                )
            t = np.array(rows, float)
            covered = int((t[:, 6] >= t[:, 5]).sum())
            print(
                f"| {name} | {period * 1e3:g} | {count} | {int(t[:, 0].sum())} | {int(t[:, 1].sum())} | {t[:, 2].min() * 1e3:.1f} | "
                f"{t[:, 3].mean() * 1e3:.0f} | {t[:, 4].mean():.1f} | {t[:, 5].max() * 1e3:.2f} | {t[:, 6].max() * 1e3:.1f} | {covered} |",
                flush=True,
            )


if __name__ == "__main__":
    heading("scipy")
    what = sys.argv[1] if len(sys.argv) > 1 else "speed"
    count = [int(a) for a in sys.argv[2:3]]
    {"speed": lambda: speed(), "worlds": lambda: worlds(*(count or [1000]), sys.argv[3:] or FAMILIES), "peers": lambda: peers(*(count or [100]), *sys.argv[3:5]),
     "tracking": lambda: tracking(*(count or [60]), sys.argv[3:]), "fabrics": lambda: fabrics(*(count or [100]))}[what]()  # fmt: skip
