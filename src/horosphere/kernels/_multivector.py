"""Multivectors with symbolic coefficients: where a geometric expression is written, once."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from ._blades import grade, product
from ._functions import Scalar
from ._graph import Symbol


def _is_zero(x: Scalar) -> bool:
    return (x.value if isinstance(x, Symbol) else x) == 0


class MV:
    """A multivector {blade: coefficient} in the null basis; coefficients are symbols or numbers.

    `*` geometric, `^` outer and `|` inner product (the grade |r - s| part), `~` reversion. Blades whose coefficient is
    exactly zero are not kept, so no code is made for them.
    """

    __slots__ = ("terms",)

    def __init__(self, terms: dict[int, Scalar]) -> None:
        self.terms = {b: c for b, c in terms.items() if not _is_zero(c)}

    @staticmethod
    def of(layout: Iterable[int], coefficients: Iterable[Scalar]) -> MV:
        """The multivector with these coefficients on the blades of `layout`."""
        return MV(dict(zip(layout, coefficients, strict=True)))

    def __getitem__(self, blade: int) -> Scalar:
        return self.terms.get(blade, 0.0)

    def on(self, layout: Iterable[int]) -> list[Scalar]:
        """The coefficients on the blades of `layout`."""
        return [self[b] for b in layout]

    def only(self, layout: Iterable[int]) -> MV:
        """The part on the blades of `layout`."""
        return MV({b: self.terms[b] for b in layout if b in self.terms})

    def __add__(self, other: MV | Scalar) -> MV:
        terms = dict(self.terms)
        for b, c in _as_mv(other).terms.items():
            terms[b] = terms[b] + c if b in terms else c
        return MV(terms)

    __radd__ = __add__

    def __neg__(self) -> MV:
        return MV({b: -c for b, c in self.terms.items()})

    def __sub__(self, other: MV | Scalar) -> MV:
        return self + -_as_mv(other)

    def __rsub__(self, other: Scalar) -> MV:
        return _as_mv(other) - self

    def times(self, other: MV, keep: Callable[[int, int, int], bool] | None = None, layout=None) -> MV:
        """Geometric product, restricted to grade triples with keep(r, s, t) and to the blades of `layout`.

        A restricted product makes no code for what is left out: use it when the rest is known to vanish or not needed.
        """
        result: dict[int, Scalar] = {}
        for a, x in self.terms.items():
            for b, y in other.terms.items():
                for c, sign in product(a, b):
                    if (keep is None or keep(grade(a), grade(b), grade(c))) and (layout is None or c in layout):
                        term = (x * y) * sign
                        result[c] = result[c] + term if c in result else term
        return MV(result)

    def __mul__(self, other: MV | Scalar) -> MV:
        if isinstance(other, MV):
            return self.times(other)
        return MV({b: c * other for b, c in self.terms.items()})

    def __rmul__(self, other: Scalar) -> MV:
        return MV({b: c * other for b, c in self.terms.items()})

    def __xor__(self, other: MV) -> MV:
        return self.times(other, lambda r, s, t: t == r + s)

    def __or__(self, other: MV) -> MV:
        return self.times(other, lambda r, s, t: t == abs(r - s))

    def __invert__(self) -> MV:
        return MV({b: -c if grade(b) * (grade(b) - 1) // 2 & 1 else c for b, c in self.terms.items()})


def _as_mv(x: MV | Scalar) -> MV:
    return x if isinstance(x, MV) else MV({0: x})


E1, E2, E3, E0, EI = (MV({1 << k: 1.0}) for k in range(5))
PSEUDOSCALAR = MV({31: 1.0})  # e1 e2 e3 (e0 ^ ei) = -I with I = e1 e2 e3 e4 e5


def apply_motor(motor: MV, x: MV, layout: Iterable[int] | None = None) -> MV:
    """M x ~M of a unit motor as x + [M, x] ~M: half the operations, since M ~M = 1.

    `layout` names the blades of the result that are wanted.
    """
    wanted = None if layout is None else tuple(layout)
    change = (motor * x - x * motor).times(~motor, layout=wanted)
    return (x if wanted is None else x.only(wanted)) + change
