from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError, unknown_name
from ..numeric import float_array, number
from ._build import Layout, lay_out
from ._certificate import FieldCertificate, certify_field
from ._charge import safe_charge, superposition_charges
from ._chart import Identity
from ._path import Path
from ._trace import METHODS, follow
from ._world import BLENDS, World, wall_distances

Array = NDArray[np.float64]
RULES = ("planar-log", "equilibrium", "safe", "monotone", "printed")
_ALIASES = {"planar": "planar-log", "W1": "simplex", "W2": "smooth"}


class HarmonicField:
    """Directions that lead from anywhere outside the obstacles to the goal, in R^n.

    `goal` (n,) metres (here and for `x`: coordinates or, in R^3, a conformal `Point`). `obstacles`: balls as (centers (m, n), radii
    (m,)), or a list of entities, shapes, stars and Joukowski maps; all are grown by `margin`; touching ones are merged into one star.
    `boundary`: width in metres of the layer in which nearby zones share the motion; `blend`: how they do: "smooth" (twice continuously
    differentiable, any width), "simplex" (width at most the least gap), "nearest" (abrupt), "sum" (all charges act, sparse worlds
    only), "printed", "printed-potential" ([Rn] (8), (9) as printed). `rule`, `exponent`: the charges, see `safe_charge`; "planar-log",
    exponent 2 or one p_i <= 1 + D_i / R_i an obstacle, has the guarantees; the others default to the exponent n. `workspace`: (lower,
    upper) corners of a box, or a ball with `center` and `radius`, not to be left. Beyond `sensor_range` metres of every zone the
    motion is straight.
    Raises InputError for a goal in a zone and for shapes, numbers and names that cannot be used; `notes` says what was enclosed,
    merged or only sampled. Source: [Rn] sections 2-3, [Humanoid] VI-VII, corrected in docs/errata.md; proofs in docs/fields.md.
    """

    def __init__(
        self,
        goal: ArrayLike,
        obstacles: Any = (),
        *,
        boundary: float | None = None,
        rule: str = "planar-log",
        exponent: ArrayLike | None = None,
        blend: str | None = None,
        workspace: Any = None,
        sensor_range: float | None = None,
        margin: float = 0.0,
    ) -> None:
        self.goal = float_array(_coordinates(goal), "goal", ndim=1).copy()
        if len(self.goal) < 2:
            raise InputError(f"expected a goal in R^n with n >= 2, got {len(self.goal)} coordinate", place="goal")
        rule = _ALIASES.get(str(rule), rule)
        if rule not in RULES:
            raise unknown_name("rule", str(rule), RULES, place="rule")
        blend = ("printed" if rule == "printed" else "smooth") if blend is None else _ALIASES.get(blend, blend)
        if blend not in BLENDS:
            raise unknown_name("blend", str(blend), BLENDS, place="blend")
        self.rule, self.margin = rule, number(margin, "margin", least=0.0)
        layout = lay_out(self.goal, obstacles, self.margin, workspace)
        self.chart, self.stars, self.names, self.notes = layout.chart, layout.stars, layout.names, layout.notes
        self.world = _world(
            self.chart.to_balls(self.goal[None])[0], layout, boundary, rule, exponent, blend, sensor_range
        )

    @property
    def dimension(self) -> int:
        return len(self.goal)

    @property
    def blend(self) -> str:
        return self.world.blend

    @property
    def boundary(self) -> float:
        """Width of the layer in which zones share the motion, metres (of the mapped space)."""
        return self.world.boundary

    def __repr__(self) -> str:
        return (
            f"HarmonicField(R^{self.dimension}, {len(self.world.radii)} zones, {len(self.world.walls)} walls, "
            f"rule={self.rule!r}, blend={self.blend!r}, boundary={self.boundary:.4g})"
        )

    def __call__(self, x: ArrayLike) -> Array:
        """Unit direction of motion (..., n) at `x` (..., n) metres; zero at the goal and at the unstable points."""
        points, shape = self._points(x)
        v = self.chart.pull_velocity(points, self.world.scaled(self.chart.to_balls(points)))
        size = np.linalg.norm(v, axis=-1, keepdims=True)
        return np.divide(v, size, out=np.zeros_like(v), where=size > 0.0).reshape(shape)

    def potential(self, x: ArrayLike) -> Array:
        """The blended potential (...) at `x` (..., n): sum of mu_i (U_goal + U_i), in the mapped space where there are shapes.

        For exponent 2: U = ln |x - g| - q ln |x - S|; else (q |x - S|^(2-p) - |x - g|^(2-p)) / (p - 2). A picture's quantity: where
        several zones share the motion, the field is not its gradient (docs/errata.md).
        """
        p = self._common_exponent()
        points, shape = self._points(x)
        z = self.chart.to_balls(points)
        m = len(self.world.radii)
        d = self.world.clearances(z)[:, :m]
        mu = self.world.weights(z)[:, :m] * self.world.charges
        away = np.linalg.norm(z - self.world.goal, axis=-1)
        with np.errstate(divide="ignore"):
            if p == 2.0:
                u = np.log(away) - (mu * np.log(d + self.world.radii)).sum(axis=1)
            else:
                u = ((mu * (d + self.world.radii) ** (2.0 - p)).sum(axis=1) - away ** (2.0 - p)) / (p - 2.0)
        return u.reshape(shape[:-1])

    def gradient(self, x: ArrayLike) -> Array:
        """The gradient (..., n) of the potential at `x` (..., n) for weights held fixed: minus the field E of the papers.

        Motion goes against it: `field(x)` is -gradient / |gradient| wherever the map, if any, is conformal. NaN at the goal.
        """
        points, shape = self._points(x)
        z = self.chart.to_balls(points)
        away = np.linalg.norm(z - self.world.goal, axis=-1, keepdims=True)
        power = self._common_exponent(strict=False)
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.chart.pull_gradient(points, -self.world.scaled(z) / away**power).reshape(shape)

    def weights(self, x: ArrayLike) -> Array:
        """The share (..., entries) of every zone, wall and the sensor range in the motion at `x` (..., n); see `names`."""
        points, shape = self._points(x)
        return self.world.weights(self.chart.to_balls(points)).reshape(*shape[:-1], -1)

    def clearance(self, x: ArrayLike) -> Array:
        """Distance (...) of `x` (..., n) to the nearest zone or wall, metres, negative inside; a lower bound beside stars."""
        points, shape = self._points(x)
        m = len(self.world.radii) - len(self.stars) if isinstance(self.chart, Identity) or self.stars else 0
        d = self.world.clearances(points)
        plain = np.concatenate(
            [d[:, :m], d[:, len(self.world.radii) : len(self.world.radii) + len(self.world.walls)]], axis=1
        )
        return np.minimum(plain.min(axis=1, initial=np.inf), self.chart.distance(points)).reshape(shape[:-1])

    def room(self, x: ArrayLike, u: ArrayLike) -> Array:
        """The straight way (...) in metres along unit `u` (..., n) from `x` (..., n) that is sure to be free.

        min over zones of d_i / (-n_i . u)_+, infinite when leaving all of them: the distance to a convex zone is convex along a
        line. Beside stars: the lower bound of their distance.
        """
        points, shape = self._points(x)
        way = np.broadcast_to(float_array(u, "u", last=self.dimension), shape).reshape(-1, self.dimension)
        m = len(self.world.radii) - len(self.stars) if isinstance(self.chart, Identity) or self.stars else 0
        y = points[:, None] - self.world.centers[:m]
        r = np.linalg.norm(y, axis=-1)
        toward = -(y * way[:, None]).sum(axis=-1) / r
        parts = [np.maximum(r - self.world.radii[:m], 0.0), self.world.clearances(points)[:, len(self.world.radii) :]]
        walls = self.world.walls
        outward = -way @ walls[:, :-2].T
        curved = walls[:, -1] > 0.0
        flat = np.where(curved, 1.0, outward)  # a ball from inside: its distance bounds the way
        clear = np.concatenate([parts[0], np.maximum(parts[1][:, : len(walls)], 0.0)], axis=1)
        rate = np.concatenate([toward, flat], axis=1)
        with np.errstate(divide="ignore"):
            free = np.where(rate > 0.0, clear / np.maximum(rate, 1e-300), np.inf)
        return np.minimum(free.min(axis=1, initial=np.inf), np.maximum(self.chart.distance(points), 0.0)).reshape(
            shape[:-1]
        )

    def grown(self, extra: float) -> HarmonicField:
        """The same field with every ball `extra` metres larger and its charge set anew (balls only; at most up to the goal)."""
        if not isinstance(self.chart, Identity):
            raise InputError("only for fields whose zones are all balls", place="grown")
        world = self.world
        far = np.linalg.norm(world.centers - self.goal, axis=1)
        radii = np.minimum(world.radii + number(extra, "extra", least=0.0), np.maximum(world.radii, 0.999 * far))
        charges = world.charges
        if len(radii):
            rule = "equilibrium" if self.rule == "planar-log" else self.rule
            charges = safe_charge(radii, far, self.dimension, rule=rule, exponent=world.exponents)
        copy = object.__new__(HarmonicField)
        copy.__dict__.update(self.__dict__)
        copy.world = World.build(
            world.goal,
            world.centers,
            radii,
            charges,
            world.exponents,
            world.walls,
            world.boundary,
            world.sensor_range,
            world.blend,
        )
        return copy

    def indexed(self, cells: int | None = None) -> HarmonicField:
        """The same field, to the last bit, with its zones in a grid of cells: a call costs about the same among 1,000 zones and among
        100,000 (n <= 3), and a zone 0.8 kB. Outside the box that holds the zones, grown by a twentieth, all of them are looked at.

        Worth building for many calls among more than about 500 zones; `trace` does not use it. `cells`: about how many (at least 1;
        by default four a zone). Raises InputError for more than three dimensions and for blends that need all zones ("sum").
        """
        if self.blend not in ("nearest", "simplex", "smooth"):
            raise InputError(f"the blend {self.blend!r} needs all zones at all places", place="indexed")
        if cells is not None and not cells >= 1:
            raise InputError(f"expected at least one cell, got {cells}", place="cells")
        if not len(self.world.radii):
            return self
        copy = object.__new__(HarmonicField)
        copy.__dict__.update(self.__dict__)
        copy.world = self.world.indexed(cells)
        return copy

    def unstable_points(self) -> Array:
        """The points (m, n) on the zones' far sides at which the field vanishes, in the order of the zones."""
        ray = self.world.centers - self.world.goal
        ray /= np.linalg.norm(ray, axis=1, keepdims=True)
        return self.chart.from_balls(self.world.centers + self.world.radii[:, None] * ray)

    def trace(
        self,
        x0: ArrayLike,
        *,
        step: float | None = None,
        tolerance: float | None = None,
        keep: float = 0.5,
        max_steps: int | None = None,
        method: str | None = None,
    ) -> Path:
        """Follow the field from `x0` (n,) to within `tolerance` metres of the goal in steps of at most `step` metres.

        method "clipped": a step keeps the fraction 1 - `keep` of every clearance and does not pass the goal; with it no step length
        leads to a collision or away from the goal. "euler" takes full steps (the papers' way; the default for rule "printed"),
        "rk4" and "dop853" integrate, without promises. Default `step`: 1/200 of the way; `tolerance`: 1e-6; the last point is the
        goal. Never raises for what happens on the way: see `Path.reason`.
        """
        start = float_array(_coordinates(x0), "x0", last=self.dimension, ndim=1).copy()
        away = float(np.linalg.norm(start - self.goal))
        step = max(away, 1e-9) / 200.0 if step is None else number(step, "step", above=0.0)
        tolerance = 1e-6 if tolerance is None else number(tolerance, "tolerance", above=0.0)
        keep = number(keep, "keep", above=0.0, most=1.0)
        if max_steps is None:
            max_steps = int(min(50.0 * away / step + 5000.0, 1e6))
        method = ("euler" if self.rule == "printed" else "clipped") if method is None else method
        if method not in METHODS:
            raise unknown_name("method", str(method), METHODS, place="method")
        reason = self.obstructed(start)
        if reason is not None:
            return Path(start[None], reason, 0.0, float(self.clearance(start)))
        return follow(
            self, start, step, tolerance, keep, int(number(max_steps, "max_steps", least=1.0, most=1e9)), method
        )

    def step(self, x: ArrayLike, step: float, *, keep: float = 0.5) -> Array:
        """Where to be one sampling period later: the clipped step of at most `step` = speed x period metres from `x` (n,)."""
        start = float_array(_coordinates(x), "x", last=self.dimension, ndim=1).copy()
        step, keep = number(step, "step", above=0.0), number(keep, "keep", above=0.0, most=1.0)
        z = self.chart.to_balls(start[None])[0]
        length = step
        for _ in range(20):
            moved = self.chart.from_balls(self.world.trace(z, length, 0.0, keep, True, 1)[0][-1:])[0]
            size = float(np.linalg.norm(moved - start))
            if size <= step * (1.0 + 1e-12):
                break
            length *= 0.95 * step / size
        return moved

    def obstructed(self, x: ArrayLike) -> str | None:
        """Why no motion can start at `x` (n,): inside a zone or outside the workspace; None where it can."""
        x = float_array(_coordinates(x), "x", last=self.dimension, ndim=1)
        d = self.world.clearances(self.chart.to_balls(x[None]))[0]
        m = len(self.world.radii)
        if m and d[:m].min() < -1e-12 * float(self.world.radii.max()):
            k = int(np.argmin(d[:m]))
            return f"start inside {self.names[k]} by {-float(self.clearance(x)):.3g} m"
        walls = d[m : m + len(self.world.walls)]
        if walls.min(initial=0.0) < 0.0:
            return f"start outside the workspace by {-walls.min():.3g} m"
        return None

    def certificate(self) -> FieldCertificate:
        """What is guaranteed here and with which margins, or which assumption fails, by how much and what to do about it."""
        return certify_field(self)

    def plot(self, path: Path | Array | None = None, **options: Any) -> Any:
        """The picture of a field of the plane or of space, see `plot_field` and `plot_space`; returns the matplotlib axes."""
        if self.dimension == 3:
            from ._plot_space import plot_space

            return plot_space(self, path, **options)
        from ._plot import plot_field

        return plot_field(self, path, **options)

    def _points(self, x: ArrayLike) -> tuple[Array, tuple[int, ...]]:
        array = float_array(_coordinates(x), "x", last=self.dimension)
        points = array.reshape(-1, self.dimension)
        return (points if points.flags.writeable else points.copy()), array.shape

    def _common_exponent(self, strict: bool = True) -> float:
        p = self.world.exponents
        if len(p) == 0 or (p == p[0]).all():
            return float(p[0]) if len(p) else 2.0
        if strict:
            raise InputError("a field whose zones have different exponents has no potential", place="exponent")
        return 2.0


def _coordinates(value: Any) -> Any:
    """Of a conformal point its Euclidean coordinates, anything else as it is."""
    return value.as_euclidean() if hasattr(value, "as_euclidean") else value


def _world(goal: Array, layout: Layout, boundary, rule: str, exponent, blend: str, sensor_range) -> World:
    n, m, radii = len(goal), len(layout.radii), layout.radii
    far = np.linalg.norm(layout.centers - goal, axis=1)
    default = 2.0 if rule == "planar-log" else float(n)
    p = float_array(default if exponent is None else exponent, "exponent")
    if p.ndim > 1 or (p.ndim == 1 and len(p) != m):
        raise InputError(
            f"expected one exponent or one for each of the {m} zones, got shape {p.shape}", place="exponent"
        )
    if rule == "printed" and exponent is not None:
        raise InputError("the printed charge has the exponent n of the space", place="exponent", remedy="leave it out")
    p = np.broadcast_to(p, (m,)).copy()
    charges = np.zeros(0)
    if m:
        named = "equilibrium" if rule == "planar-log" else rule
        charges = safe_charge(radii, far, n, rule=named, exponent=p)
        if blend == "sum":
            charges = superposition_charges(layout.centers, radii, far)
    reach = np.inf if sensor_range is None else number(sensor_range, "sensor_range", above=0.0)
    if boundary is None:
        width = 0.5 * float(radii.mean()) if m else 1.0
        if blend == "simplex" or blend.startswith("printed"):
            trial = World.build(goal, layout.centers, radii, charges, p, layout.walls, width, reach, blend)
            walls = wall_distances(layout.walls, layout.centers) - radii[:, None]
            width = min(width, max(trial.least_gap()[0], 0.0), float(walls.min(initial=np.inf)), reach)
    else:
        width = number(boundary, "boundary", least=0.0)
    return World.build(goal, layout.centers, radii, charges, p, layout.walls, width, reach, blend)
