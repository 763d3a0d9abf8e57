from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..numeric import at_least
from ._charge import interaction, safe_charge
from ._world import COMPILED

if TYPE_CHECKING:
    from ._field import HarmonicField

Array = NDArray[np.float64]
INVARIANCE, PROGRESS, CONVERGENCE, RATE = "invariance", "progress", "convergence", "clearance rate"
_MEANING = {
    INVARIANCE: "no motion that starts outside the zones enters one, at any sampling period",
    PROGRESS: "the distance to the goal never grows",
    CONVERGENCE: "every start but a set of measure zero reaches the goal",
    RATE: "where one zone alone has weight, its clearance d(t) along x' = E stays above min(d(0), D - R) exp(-rate t)",
}


@dataclass(frozen=True, slots=True)
class Check:
    """One assumption: `margin` is how far it is from failing (metres unless the name says otherwise), negative where it fails."""

    name: str
    holds: bool
    margin: float
    subject: str
    needed_for: tuple[str, ...]
    remedy: str = ""

    def __str__(self) -> str:
        text = f"{'ok ' if self.holds else 'FAILS'} {self.name}: margin {at_least(self.margin)} at {self.subject}"
        return text if self.holds else f"{text}; {self.remedy}"


@dataclass(frozen=True, slots=True, eq=False)
class FieldCertificate:
    """What a field guarantees. `checks` lists every assumption with its margin, `guarantees` what follows from those that hold.

    `rates` (m,) in 1/s are the clearance rates of the zones for the un-normalised field, and of the instability of their
    unstable points; `space` says in which space distance and clearance are meant; `notes` what was only sampled.
    """

    guarantees: tuple[str, ...]
    checks: tuple[Check, ...]
    rates: Array
    space: str
    notes: tuple[str, ...] = ()

    @property
    def granted(self) -> bool:
        """All of invariance, progress and convergence."""
        return {INVARIANCE, PROGRESS, CONVERGENCE} <= set(self.guarantees)

    @property
    def refusals(self) -> tuple[Check, ...]:
        return tuple(check for check in self.checks if not check.holds)

    def __bool__(self) -> bool:
        return self.granted

    def __str__(self) -> str:
        lines = [f"guaranteed ({self.space}):" if self.guarantees else "nothing is guaranteed:"]
        lines += [f"  {name}: {_MEANING[name]}" for name in self.guarantees]
        lines += [f"  {check}" for check in self.checks]
        return "\n".join([*lines, *(f"  note: {note}" for note in self.notes)])


def certify_field(field: HarmonicField) -> FieldCertificate:
    """Check every assumption of the theorems of docs/fields.md."""
    world, names = field.world, field.names
    m, all_three = len(world.radii), (INVARIANCE, PROGRESS, CONVERGENCE)
    far = np.linalg.norm(world.centers - world.goal, axis=1)
    checks: list[Check] = []

    def add(name, values: Array, subjects, needed, remedy, strict: bool = True) -> None:
        if len(values) == 0:
            return
        k = int(np.argmin(values))
        value = float(values[k])
        checks.append(Check(name, value > 0.0 if strict else value >= 0.0, value, subjects[k], needed, remedy))

    add("goal outside the zones", far - world.radii, names, all_three, "move the goal or shrink the zone")
    gap, pair = world.least_gap()
    if field.stars and m > 1:
        gaps = _star_gaps(field, world.gaps()[:m, :m])
        pair = tuple(int(k) for k in np.unravel_index(np.argmin(gaps), gaps.shape))
        gap = float(gaps[pair])
    pair_gaps = np.array([gap] if m > 1 else [])
    pair_names = [f"{names[pair[0]]} and {names[pair[1]]}"] if m > 1 else []
    add("zones disjoint", pair_gaps, pair_names, all_three, "shrink the zones or the margin, or let them be merged")
    if field.stars:
        # they were made so narrow that they are; see `shell_widths`
        add("shells disjoint, least width", np.array(field.chart.widths), names[m - len(field.stars) :], all_three,
            "move the body off its neighbour")  # fmt: skip
    if len(world.walls):
        wall_gap = world.gaps()[:m, m : m + len(world.walls)]
        if field.stars:
            from ._shells import wall_gap as star_wall_gap

            first = m - len(field.stars)
            wall_gap = wall_gap.copy()
            for i, star in enumerate(field.stars):
                wall_gap[first + i] = [star_wall_gap(star, wall) for wall in world.walls]
        pairs_w = [f"{names[i]} and {names[m + j]}" for i in range(m) for j in range(len(world.walls))]
        add("zones off the walls", wall_gap.ravel(), pairs_w, all_three, "shrink the zone or move the wall")
        from ._world import wall_distances

        inside = wall_distances(world.walls, field.goal[None])[0]
        add("workspace star-shaped about the goal", inside, names[m:], all_three, "move the goal inside")
    _check_blend(field, world, pair_gaps, pair_names, add)
    _check_charges(field, world, far, add)
    guarantees = tuple(g for g in all_three if all(check.holds for check in checks if g in check.needed_for))
    if field.blend not in COMPILED or field.rule == "printed":
        # the clipped step keeps any field out of the zones, but not this one's own motion
        guarantees = tuple(g for g in guarantees if g != INVARIANCE or field.rule != "printed")
    rates = (world.exponents - 1.0) * far / (world.radii * (world.radii + far) ** 2) if m else np.zeros(0)
    if INVARIANCE in guarantees and (world.exponents == 2.0).all() and field.blend != "sum":
        guarantees = (*guarantees, RATE)
    mapped = type(field.chart).__name__
    space = {
        "Identity": "distances are Euclidean",
        "Shells": "distances are those of the space in which every star is a ball; free space itself is the robot's",
        "Conformal": "distances are those of the plane in which the shape is a circle; free space itself is the robot's",
    }[mapped]
    return FieldCertificate(guarantees, tuple(checks), rates, space, field.notes)


def _check_blend(field, world, pair_gaps: Array, pair_names, add) -> None:
    needed = (INVARIANCE, PROGRESS, CONVERGENCE)
    if field.blend == "simplex":
        add("boundary within the least gap", pair_gaps - world.boundary, pair_names, needed,
            "narrow the boundary or use blend='smooth'", False)  # fmt: skip
        if len(world.walls):
            gap = world.gaps()[: len(world.radii), len(world.radii) :].min(initial=np.inf)
            add("boundary within the gap to the walls", np.array([gap - world.boundary]), ["the walls"], needed,
                "narrow the boundary or use blend='smooth'", False)  # fmt: skip
    elif field.blend == "nearest":
        add("direction continuous (no unit)", np.array([-1.0 if len(world.radii) > 1 else 1.0]), ["the equidistant surfaces"],
            (CONVERGENCE,), "use blend='smooth': abrupt switching chatters")  # fmt: skip
    elif field.blend == "sum":
        radius = np.abs(np.linalg.eigvals(interaction(world.centers, world.radii))).max(initial=0.0)
        add("charges solvable: 1 - spectral radius (no unit)", np.array([1.0 - radius]), ["the whole world"], (INVARIANCE,),
            "use blend='smooth': a sum of fields suits sparse worlds only")  # fmt: skip
        add("attraction from infinity: 1 - sum of charges (no unit)", np.array([1.0 - world.charges.sum()]), ["the whole world"],
            (CONVERGENCE,), "use blend='smooth'")  # fmt: skip
        add("progress with a sum of fields (no unit)", np.array([-1.0 if len(world.radii) > 1 else 1.0]), ["the whole world"],
            (PROGRESS, CONVERGENCE), "use blend='smooth'")  # fmt: skip
    elif field.blend.startswith("printed"):
        bad = -1.0 if len(world.radii) > 1 or field.blend == "printed-potential" else 1.0
        add("weights as printed are positive and continuous (no unit)", np.array([bad]), ["three zones at a time"], needed,
            "use blend='smooth' (docs/errata.md)")  # fmt: skip


def _check_charges(field, world, far: Array, add) -> None:
    if len(world.radii) == 0 or (far <= world.radii).any() or field.blend == "sum":
        return
    p, names = world.exponents, field.names
    n = field.dimension
    safe = safe_charge(world.radii, far, n, rule="safe", exponent=p)
    most = safe_charge(world.radii, far, n, rule="monotone", exponent=p)
    add("charge not below the least safe one, relative (no unit)", world.charges / safe - 1.0 + 1e-12, names,
        (INVARIANCE, CONVERGENCE), "take rule='planar-log' or rule='safe'")  # fmt: skip
    add("charge not above the largest with progress, relative (no unit)", 1.0 - world.charges / most + 1e-12, names,
        (PROGRESS, CONVERGENCE), "take rule='planar-log', or an exponent of at most 1 + D / R")  # fmt: skip


def _star_gaps(field, gaps: Array) -> Array:
    """Lower bounds of the gaps with the stars' own outlines; where one reaches into a bay of another the sum of the shell widths,
    which were proven disjoint."""
    from ._merge import as_star
    from ._shells import separation

    world, m = field.world, len(gaps)
    first = m - len(field.stars)
    bodies = [as_star((world.centers[k], float(world.radii[k]), "")) for k in range(first)] + list(field.stars)
    widths = [0.0] * first + list(field.chart.widths)
    gaps = gaps.copy()
    for i in range(first, m):
        for j in range(i):
            a, b, shells = bodies[i], bodies[j], widths[i] + widths[j]
            far = separation(a, b)
            gaps[i, j] = gaps[j, i] = far if far > 0.0 else shells
    return gaps
