"""Named constants of the algebra."""

from __future__ import annotations

from typing import NamedTuple

from ._multivector import Multivector


class Basis(NamedTuple):
    """e1..e5, the origin e0 = (e5 - e4)/2, infinity ei = e4 + e5, Ie = e123, E = ei^e0 = e45, I = e12345."""

    e1: Multivector
    e2: Multivector
    e3: Multivector
    e4: Multivector
    e5: Multivector
    e0: Multivector
    ei: Multivector
    Ie: Multivector
    E: Multivector
    I: Multivector


basis = Basis(
    *(Multivector.blade(f"e{k}") for k in range(1, 6)),
    e0=Multivector.vector([0, 0, 0, -0.5, 0.5]),
    ei=Multivector.vector([0, 0, 0, 1, 1]),
    Ie=Multivector.blade("e123"),
    E=Multivector.blade("e45"),
    I=Multivector.blade("e12345"),
)
