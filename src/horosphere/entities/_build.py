"""Checks and helpers that constructors share: vectors, batches, unit vectors, blades."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..algebra import Batch, Multivector
from ..errors import InputError
from ..numeric import float_array

Array = NDArray[np.float64]
EPS = float(np.finfo(np.float64).eps)


def vectors(*named: tuple[ArrayLike, str]) -> list[Array]:
    """Checked (..., 3) arrays broadcast to one batch shape; a Point counts as its coordinates."""
    arrays = []
    for value, name in named:
        if hasattr(value, "as_euclidean"):
            value = value.as_euclidean()  # type: ignore[union-attr]
        arrays.append(float_array(value, name, last=3))
    return together(arrays, [name for _, name in named])


def together(arrays: list[Array], names: list[str]) -> list[Array]:
    """The arrays (..., k) broadcast over their leading axes. Raises InputError naming the shapes that do not fit."""
    try:
        batch = np.broadcast_shapes(*(a.shape[:-1] for a in arrays))
    except ValueError:
        shapes = ", ".join(f"{n} {a.shape[:-1]}" for n, a in zip(names, arrays))
        raise InputError(f"expected batch shapes that broadcast, got {shapes}", place=" and ".join(names)) from None
    return [np.broadcast_to(a, (*batch, a.shape[-1])) for a in arrays]


def check_shapes(a: Batch, b: Batch) -> None:
    """Raise InputError when the batch shapes of two values do not broadcast."""
    try:
        np.broadcast_shapes(a.shape, b.shape)
    except ValueError:
        raise InputError(f"expected batch shapes that broadcast, got {a.shape} and {b.shape}", place="other") from None


def length(v: Array) -> Array:
    """|v| over the last axis, (...), without overflow or underflow of the squares."""
    if v.ndim == 1:  # one vector: numpy's overhead would be ten times the work
        return np.float64(math.hypot(*v.tolist()))  # type: ignore[return-value]
    size = np.abs(v).max(-1)
    safe = np.where(size > 0.0, size, 1.0)
    return size * np.sqrt(np.sum((v / safe[..., None]) ** 2, axis=-1))


def cross(a: Array, b: Array) -> Array:
    """a x b over the last axis (np.cross, several times faster on single vectors)."""
    if a.ndim == 1 and b.ndim == 1:
        (x, y, z), (u, v, w) = a.tolist(), b.tolist()
        return np.array((y * w - z * v, z * u - x * w, x * v - y * u))
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    u, v, w = b[..., 0], b[..., 1], b[..., 2]
    first = y * w - z * v
    out = np.empty((*first.shape, 3))
    out[..., 0], out[..., 1], out[..., 2] = first, z * u - x * w, x * v - y * u
    return out


def unit(v: Array, name: str, remedy: str) -> Array:
    """v/|v|; raises InputError at the first zero vector."""
    size = length(v)
    refuse(size == 0.0, f"{name} has length zero", name, remedy)
    out = v / size[..., None]
    return out / np.sqrt(np.sum(out * out, axis=-1))[..., None]  # subnormal vectors need the second turn


def refuse(bad: NDArray[np.bool_], message: str, place: str, remedy: str) -> None:
    """Raise InputError naming the first element of the batch where `bad` holds."""
    if np.any(bad):
        where = "" if np.ndim(bad) == 0 else f" at index {tuple(int(i) for i in np.argwhere(bad)[0])}"
        raise InputError(message + where, place=place, remedy=remedy)


def non_negative(value: ArrayLike, name: str) -> Array:
    """A checked array (...) of radii."""
    array = float_array(value, name)
    refuse(array < 0.0, f"expected a radius >= 0, got {array[array < 0.0].flat[0] if np.any(array < 0) else ''}", name,
           "imaginary rounds come out of meets or from_center_radius_squared")  # fmt: skip
    return array


def triangle(a: Array, b: Array, c: Array, what: str) -> tuple[Array, Array, Array]:
    """The points turned (cyclically) so that the first is an end of the shortest side; InputError when collinear.

    Collinear: the triangle is not higher than 8 units in the last place of its coordinates.
    """
    ab, bc, ca = length(b - a), length(c - b), length(a - c)
    turn = ((bc < ab) & (bc < ca))[..., None]
    p, q, r = np.where(turn, b, a), np.where(turn, c, b), np.where(turn, a, c)
    area = length(cross(q - p, r - p))
    longest = np.maximum(np.maximum(ab, bc), ca)
    size = np.maximum(np.abs(a).max(-1), np.maximum(np.abs(b).max(-1), np.abs(c).max(-1)))
    shortest = np.minimum(np.minimum(ab, bc), ca)
    refuse(shortest == 0.0, f"{what} needs three different points, two coincide", "points", "move one of them")
    refuse(area <= 8.0 * EPS * longest * np.maximum(size, longest), f"{what} needs three points that are not collinear",
           "points", "use Line for collinear points")  # fmt: skip
    return p, q, r


def blade_of(blade: Multivector, grade: int, kind: str) -> Multivector:
    """The blade itself when all of it has this grade; InputError otherwise."""
    if not isinstance(blade, Multivector):
        raise InputError(f"expected a Multivector, got {type(blade).__name__}", place="blade")
    found = blade.grades()
    if found not in ((grade,), ()):
        raise InputError(f"expected an IPNS blade of grade {grade} for a {kind}, got grades {found}", place="blade")
    return blade


def null_coefficients(blade: Multivector, *names: str) -> Array:
    """Coefficients (..., k) over the named outer products of null-basis vectors."""
    return np.stack([blade.null(n) for n in names], axis=-1)


def same_blade(blade: Multivector, value: Multivector, kind: str) -> None:
    """Raise InputError unless `value` is a multiple of `blade`: it was no blade of this kind."""
    a, b = blade.coefficients, value.coefficients
    scale = np.sum(a * b, axis=-1, keepdims=True) / np.maximum(np.sum(b * b, axis=-1, keepdims=True), 1e-300)
    bad = np.abs(a - scale * b).max(-1) > 1e-8 * np.abs(a).max(-1)
    refuse(bad, f"this blade is no {kind}", "blade", f"{kind}.from_ipns and from_opns take blades of that type only")
