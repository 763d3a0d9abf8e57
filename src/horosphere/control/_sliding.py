from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..errors import unknown_name
from ..numeric import number

Array = NDArray[np.float64]
LAWS = ("implicit-unit-vector", "explicit", "boundary-layer", "super-twisting")


@dataclass(slots=True)
class SlidingMode:
    """Sliding-mode control of a double integrator x'' = u + w, |u| <= gain: drives s = v - v_d(x) to zero and keeps it there.

    Laws, s the velocity error in m/s and h the period in s:

    - "implicit-unit-vector": u = -gain s / max(|s|, gain h), the unit vector by backward Euler; the same as a boundary layer of width
      gain h. With `feedforward` (default) s is taken against the velocity wanted one period ahead, so that a turning field is met.
    - "explicit": u = -gain s / |s|, the unit vector held over the period ([Rn]'s law); chatters.
    - "boundary-layer": u = -gain s / max(|s|, layer).
    - "super-twisting": u = -k1 sqrt(|s|) s/|s| + z, z' = -k2 s/|s|, k1 = 1.5 sqrt(c), k2 = 1.1 c, c = `twist`, bounded by gain.

    `gain` in m/s^2, `layer` in m/s, `twist` in m/s^3.
    """

    gain: float
    law: str = "implicit-unit-vector"
    feedforward: bool = True
    layer: float = 0.1
    twist: float = 4.0
    _integral: Array | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        if self.law not in LAWS:
            raise unknown_name("control law", str(self.law), LAWS, place="law")
        for name in ("gain", "layer", "twist"):
            number(getattr(self, name), name, above=0.0)

    def reset(self) -> None:
        """Forget the integral of the super-twisting law."""
        self._integral = None

    @property
    def looks_ahead(self) -> bool:
        return self.law == "implicit-unit-vector" and self.feedforward

    def __call__(self, error: Array, period: float) -> Array:
        """The input u (n,) in m/s^2 for the velocity error s (n,) in m/s, held for `period` seconds."""
        size = float(np.linalg.norm(error))
        if self.law == "implicit-unit-vector":
            return -self.gain * error / max(size, self.gain * period)
        if self.law == "boundary-layer":
            return -self.gain * error / max(size, self.layer)
        sign = error / size if size > 0.0 else np.zeros_like(error)
        if self.law == "explicit":
            return -self.gain * sign
        if self._integral is None:
            self._integral = np.zeros_like(error)
        u = -1.5 * np.sqrt(self.twist * size) * sign + self._integral
        self._integral = self._integral - 1.1 * self.twist * period * sign
        return u / max(1.0, float(np.linalg.norm(u)) / self.gain)
