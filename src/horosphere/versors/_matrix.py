"""Checks on matrices of rotations and of rigid transforms."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..entities._build import refuse
from ..errors import InputError
from ..numeric import float_array

_TOLERANCE = 1e-6


def square(matrix: ArrayLike, n: int, name: str) -> NDArray[np.float64]:
    """A checked float array (..., n, n)."""
    array = float_array(matrix, name)
    if array.shape[-2:] != (n, n):
        raise InputError(f"expected shape (..., {n}, {n}), got {array.shape}", place=name)
    return array


def rotation(matrix: ArrayLike, name: str) -> NDArray[np.float64]:
    """Rotation matrices (..., 3, 3) as (..., 9); raises InputError when R^T R is not 1 or the determinant not +1."""
    r = square(matrix, 3, name)
    _check(r, name)
    return r.reshape(*r.shape[:-2], 9)


def rigid(matrix: ArrayLike, name: str) -> NDArray[np.float64]:
    """Rigid transforms (..., 4, 4) as (..., 16); raises InputError for any other matrix."""
    t = square(matrix, 4, name)
    off = np.abs(t[..., 3, :] - np.array([0.0, 0.0, 0.0, 1.0])).max(-1, initial=0.0) > _TOLERANCE
    refuse(off, "expected the last row 0 0 0 1", name, "a rigid transform acts on homogeneous coordinates as columns")
    _check(t[..., :3, :3], name)
    return t.reshape(*t.shape[:-2], 16)


def _check(r: NDArray[np.float64], name: str) -> None:
    off = np.abs(np.swapaxes(r, -1, -2) @ r - np.eye(3)).max((-1, -2), initial=0.0)
    refuse(off > _TOLERANCE, "expected a rotation: R^T R = 1 within 1e-6", name, "no scale, no shear")
    refuse(np.linalg.det(r) < 0.0, "expected a rotation, this one mirrors (determinant -1)", name, "use a Reflector")
