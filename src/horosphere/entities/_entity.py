"""The abstract base of the six entities, and the table of what is stored and what blade it stands for.

| type | `array`, last axis | IPNS blade | OPNS blade of |
|---|---|---|---|
| Point | x, 1, x^2/2 over (e1, e2, e3, e0, ei) | x + e0 + x^2/2 ei | itself |
| Sphere | center, radius^2 | P(center) - radius^2/2 ei | a ^ b ^ c ^ d |
| Plane | normal n, distance d | n + d ei | a ^ b ^ c ^ ei, n along (b-a) x (c-a) |
| Circle | center, normal n, radius^2 | sphere ^ plane | a ^ b ^ c, n along (b-a) x (c-a) |
| Line | (n3, -n2, n1, m1, m2, m3) over (e12, e13, e23, e1i, e2i, e3i) | n I_e + m ei, m = p x n | a ^ b ^ ei |
| PointPair | center c, unit direction u, radius^2 | (a ^ b) I / |a - b| | a ^ b, a = c - r u, b = c + r u |

Rounds are in centred form (place, direction, squared radius, negative where imaginary), not as the blade about the
origin: there a radius r at distance c has the relative error eps (c/r)^2, at 1e4 and 1e-3 about 1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ..algebra import Batch, Multivector
from ..algebra._format import combination, latex_name
from ..algebra._tables import NULL_NAMES, TO_NULL
from ..errors import InputError

# (type of a, type of b) -> function; filled by _meet.py, _distance.py and _angle.py
MEETS: dict[tuple[type, type], Callable[[Any, Any], Any]] = {}
DISTANCES: dict[tuple[type, type], Callable[[Any, Any], NDArray[np.float64]]] = {}
ANGLES: dict[tuple[type, type], Callable[[Any, Any], NDArray[np.float64]]] = {}

_LATEX_NAMES = ["1"] + [latex_name("e" + n) for n in NULL_NAMES[1:]]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Entity(Batch):
    """Abstract geometric entity of Table I [Humanoid]; leading axes of `array` are batch."""

    @property
    def is_real(self) -> NDArray[np.bool_]:
        """(...) whether it has a point of space: False for imaginary rounds and for meets of parallels."""
        raise NotImplementedError

    def as_ipns(self) -> Multivector:
        """The blade with the entity as null space of the inner product: x | X = 0 [Humanoid, Table I]."""
        raise NotImplementedError

    def as_opns(self) -> Multivector:
        """The blade with the entity as null space of the outer product, X* = X I^-1: x ^ X* = 0."""
        return self.as_ipns().dual()

    @classmethod
    def from_ipns(cls, blade: Multivector) -> Self:
        """From an IPNS blade of any weight. Raises InputError when it is no blade of this type."""
        raise NotImplementedError

    @classmethod
    def from_opns(cls, blade: Multivector) -> Self:
        """From an OPNS blade of any weight. Raises InputError when it is no blade of this type."""
        if not isinstance(blade, Multivector):
            raise InputError(f"expected a Multivector, got {type(blade).__name__}", place="blade")
        return cls.from_ipns(blade.undual())

    # ---- pairs of entities
    def __and__(self, other: Entity) -> Any:
        """Meet: the entity of a.as_ipns() ^ b.as_ipns(), oriented as that product. InputError where there is none."""
        meet = MEETS.get((type(self), type(other)))
        return _missing("meet", self, other, MEETS) if meet is None else meet(self, other)

    def distance_to(self, other: Entity) -> NDArray[np.float64]:
        """Distance in metres (...), the smallest between two points of the two; spheres count as solid balls.

        So a distance to a Sphere is signed: negative is the depth of penetration. All others are >= 0. +inf where one
        of the two has no real point. Raises InputError for a pair without a closed form.
        """
        distance = DISTANCES.get((type(self), type(other)))
        return _missing("distance", self, other, DISTANCES) if distance is None else distance(self, other)

    def angle_to(self, other: Entity) -> NDArray[np.float64]:
        """Angle in radians (...): in [0, pi] of two directions or two normals, in [0, pi/2] of a direction and a plane.

        Of spheres and planes that of a.as_ipns() | b.as_ipns(), for two spheres between the radii at a common point;
        NaN where they do not meet. Raises InputError for a pair that has none.
        """
        angle = ANGLES.get((type(self), type(other)))
        return _missing("angle", self, other, ANGLES) if angle is None else angle(self, other)

    def _latex(self) -> str:
        return combination(TO_NULL @ self.as_ipns().coefficients, _LATEX_NAMES, latex=True)


def _missing(what: str, a: Entity, b: object, table: dict) -> Any:
    kind = type(b).__name__
    if isinstance(b, Batch):
        message = f"{type(a).__name__} and {kind} have no {what} of one type"
    else:
        message = f"expected an entity, got {kind}"
    raise InputError(message, place="other", choices=[y.__name__ for x, y in table if x is type(a)])
