"""What inverse kinematics returns: every branch of every target, as arrays."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..numeric import float_array
from ..robots._robot import require_robot

Floats = NDArray[np.float64]


class IkSolutions:
    """All branches of the inverse kinematics of a batch of targets.

    Attributes
    ----------
    q: (..., branches, n) joint angles in (-pi, pi], radians, shifted by a turn where only that lies inside the limits.
       Rows that are not valid hold the nearest posture the formulas give, never NaN.
    valid: (..., branches) the posture reaches the target. Joint limits are not part of it: see `within_limits`.
    branch: (branches, bits) what tells the branches apart, named by `bits`; a bit is 1 for the second choice.
    bits: names of the bits, e.g. ("back", "elbow", "flip").
    is_closed_form: all branches by formula; False: a numerical search, whose rows are what it found.
    flags: (...) or (..., branches) bool arrays by name: degenerate cases, in which a free angle was kept from the seed.
    free: (..., branches) the value of the redundancy (phi, psi, q7) of each row where the solver chose it, else None.
    """

    __slots__ = ("_flags", "_free", "_reason", "_residual", "bits", "branch", "is_closed_form", "q", "valid")

    def __init__(
        self,
        q: Floats,
        valid: NDArray[np.bool_],
        branch: NDArray[np.int64],
        residual: Floats | Callable[[], Floats],
        is_closed_form: bool,
        reason: str | NDArray[Any] | Callable[[], Any] = "",
        *,
        bits: tuple[str, ...] = (),
        flags: Mapping[str, NDArray[np.bool_]] | Callable[[], Mapping[str, NDArray[np.bool_]]] | None = None,
        free: Floats | float | None = None,
    ) -> None:
        self.q, self.valid, self.branch, self.is_closed_form = q, valid, branch, is_closed_form
        self.bits, self._flags, self._free = bits, flags if flags is not None else {}, free
        self._residual, self._reason = residual, reason

    @property
    def flags(self) -> Mapping[str, NDArray[np.bool_]]:
        if callable(self._flags):
            self._flags = self._flags()
        return self._flags

    @property
    def free(self) -> Floats | None:
        if type(self._free) is float:
            self._free = np.full(self.valid.shape, self._free)
        return self._free  # type: ignore[return-value]

    @property
    def residual(self) -> Floats:
        """(..., branches) larger of the position error (m) and the rotation error (rad) of forward(q) against the
        target.
        """
        if callable(self._residual):
            self._residual = self._residual()
        return self._residual

    @property
    def reason(self) -> Any:
        """Why a target has no valid branch ("" where it has one): a str, for a batch an object array of them."""
        if callable(self._reason):
            self._reason = self._reason()
        return self._reason

    @property
    def solved(self) -> NDArray[np.bool_]:
        """(...) at least one branch is valid."""
        return np.asarray(self.valid.any(axis=-1))

    def within_limits(self, robot, tolerance: float = 1e-9) -> NDArray[np.bool_]:
        """(..., branches) the row is valid and inside the joint limits of `robot` (to `tolerance` radians)."""
        limits = require_robot(robot).limits
        lower, upper = limits.lower - tolerance, limits.upper + tolerance
        return self.valid & ((self.q >= lower) & (self.q <= upper)).all(axis=-1)

    def nearest(self, q: ArrayLike, robot=None) -> Floats:
        """(..., n) the valid row with the smallest largest joint step from `q` (..., n); NaN where no row is valid.

        With `robot`, only rows within its limits count.
        """
        reference = float_array(q, "q", last=self.q.shape[-1])
        usable = self.valid if robot is None else self.within_limits(robot)
        step = np.abs(self.q - reference[..., None, :]).max(axis=-1)
        row = np.asarray(np.argmin(np.where(usable, step, np.inf), axis=-1))
        best = np.take_along_axis(self.q, row[..., None, None], axis=-2)[..., 0, :]
        some = np.asarray(usable.any(axis=-1))
        return np.where(some[..., None], best, np.nan)

    def explain(self, robot, target) -> str:
        """Why no row is inside the joint limits of `robot`, for one target: "" if one is.

        Reached only outside the limits: by which branch most nearly, and which joint would have to go where. Not reached: the
        reason, and how far and where the nearest pose is that a numerical search inside the limits finds.
        """
        from ._explain import explain

        return explain(self, robot, target)

    def name(self, row: int) -> str:
        """The branch of a row in words, e.g. "back=0 elbow=1 flip=0"."""
        if not 0 <= row < len(self.branch):
            raise InputError(f"expected a row in 0..{len(self.branch) - 1}, got {row}", place="row")
        return " ".join(f"{bit}={value}" for bit, value in zip(self.bits, self.branch[row]))

    def __repr__(self) -> str:
        kind = "closed form" if self.is_closed_form else "numerical"
        if self.valid.ndim == 1:
            return f"IkSolutions({kind}, {int(self.valid.sum())} of {len(self.valid)} branches valid)"
        return f"IkSolutions({kind}, targets {self.valid.shape[:-1]}, {int(self.solved.sum())} solved)"


@cache
def branch_table(bits: int) -> NDArray[np.int64]:
    """(2^bits, bits) rows in counting order, the first bit most significant."""
    table = (np.arange(2**bits)[:, None] >> np.arange(bits - 1, -1, -1)) & 1
    table.setflags(write=False)
    return table
