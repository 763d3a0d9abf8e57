"""The 32 basis blades of G(4,1) in the null basis (e1, e2, e3, e0, ei) and their products.

A blade is an int whose bit k says whether basis vector k is a factor; e0.e0 = ei.ei = 0 and e0.ei = -1, where e0 is the
point at the origin and ei the point at infinity. Every blade is (Euclidean part) ^ (part in span{1, e0, ei, e0^ei}), so
the product needs the sign of the Euclidean part, one swap sign, and the 4 x 4 table of the null part.
"""

from __future__ import annotations

from functools import cache

NAMES = ("1", "2", "3", "0", "i")
_E0, _EI, _W = 1, 2, 3  # the null part: e0, ei, and W = e0 ^ ei = e0 ei + 1

_NULL_PRODUCT: dict[tuple[int, int], tuple[tuple[int, float], ...]] = {
    (_E0, _E0): (),
    (_EI, _EI): (),
    (_E0, _EI): ((_W, 1.0), (0, -1.0)),
    (_EI, _E0): ((_W, -1.0), (0, -1.0)),
    (_E0, _W): ((_E0, 1.0),),
    (_W, _E0): ((_E0, -1.0),),
    (_EI, _W): ((_EI, -1.0),),
    (_W, _EI): ((_EI, 1.0),),
    (_W, _W): ((0, 1.0),),
}


def grade(blade: int) -> int:
    """The number of basis vectors in a blade."""
    return blade.bit_count()


@cache
def product(a: int, b: int) -> tuple[tuple[int, float], ...]:
    """Geometric product of two blades as ((blade, coefficient), ...); at most two terms."""
    euclid_a, euclid_b, null_a, null_b = a & 7, b & 7, a >> 3, b >> 3
    swaps = grade(null_a) * grade(euclid_b)  # move the null part of a past the Euclidean part of b
    shifted = euclid_a >> 1
    while shifted:
        swaps += grade(shifted & euclid_b)
        shifted >>= 1
    sign = -1.0 if swaps & 1 else 1.0
    euclid = euclid_a ^ euclid_b
    null = _NULL_PRODUCT.get((null_a, null_b), ((null_a | null_b, 1.0),))
    return tuple((euclid | part << 3, sign * value) for part, value in null)


def blade(name: str) -> int:
    """The blade with this name, e.g. "12", "3i", "123i"; "" or "s" is the scalar."""
    return 0 if name == "s" else sum(1 << NAMES.index(letter) for letter in name)


def blades(*names: str) -> tuple[int, ...]:
    """Several blades: the layout of a typed array's last axis."""
    return tuple(blade(name) for name in names)


SCALAR = blades("s")
EUCLIDEAN = blades("1", "2", "3")
VECTOR = blades("1", "2", "3", "0", "i")  # a point, sphere or plane (IPNS)
BIVECTOR = blades("12", "13", "23", "1i", "2i", "3i")  # a line (IPNS), the logarithm of a motor
ROTOR = blades("s", "12", "13", "23")
MOTOR = blades("s", "12", "13", "23", "1i", "2i", "3i", "123i")
LINE = blades("12i", "13i", "23i", "10i", "20i", "30i")  # a line (OPNS)
PAIR = tuple(b for b in range(32) if grade(b) == 2)  # grade 2 whole: circle (IPNS), point pair (OPNS)
CIRCLE = tuple(b for b in range(32) if grade(b) == 3)  # grade 3 whole: point pair (IPNS), circle (OPNS)
QUADVECTOR = tuple(b for b in range(32) if grade(b) == 4)  # sphere, plane (OPNS)
