from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..numeric import number, whole_number

Array = NDArray[np.float64]
Direction = Callable[[Array], Array]


@dataclass(frozen=True, slots=True)
class SpeedProfile:
    """How fast to follow a field of directions: V = min(fastest, sqrt(2 a r), sqrt(b / curvature)), and slower ahead of a bend.

    `fastest` in m/s, `braking` a and `lateral` b in m/s^2, r the distance to the goal. The curvature of the gradient line is the
    turn of the direction per metre; it is looked for over the braking distance, in `looks` steps, and a bend at distance l ahead
    allows V^2 = V_bend^2 + 2 a l. `slow_down` > 0 is [Rn]'s first heuristic: V is also at most `slow_down` / (2 turn) within a
    period of the unstable point, where the turn has no bound.
    """

    fastest: float = 1.0
    braking: float = 1.5
    lateral: float = 1.5
    looks: int = 4
    slow_down: float = 0.0

    def __post_init__(self) -> None:
        for name in ("fastest", "braking", "lateral"):
            number(getattr(self, name), name, above=0.0)
        whole_number(self.looks, "looks", 1)
        number(self.slow_down, "slow_down", least=0.0)

    def __call__(self, x: Array, goal: Array, direction: Direction) -> tuple[float, Array]:
        """The speed in m/s and the unit direction at `x` (n,)."""
        e = direction(x)
        rest = float(np.linalg.norm(x - goal))
        speed = min(self.fastest, float(np.sqrt(2.0 * self.braking * rest)))
        ahead = min(0.5 * speed**2 / self.braking, rest)
        piece = max(ahead / self.looks, 1e-6)
        here, last, gone = x, e, 0.0
        for _ in range(self.looks):
            here = here + piece * last
            then = direction(here)
            turn = float(np.linalg.norm(then - last)) / piece
            if turn > 0.0:
                at_bend = min(self.lateral / turn, (self.slow_down / (2.0 * turn)) ** 2 if self.slow_down else np.inf)
                speed = min(speed, float(np.sqrt(at_bend + 2.0 * self.braking * gone)))
            gone += piece
            last = then
        return speed, e
