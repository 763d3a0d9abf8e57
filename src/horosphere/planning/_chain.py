"""Choose one configuration for every point of a path: the cheapest chain in which neighbours are close (never greedy)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class ChainSearch:
    """The cheapest chains to every configuration of the last layer, grown layer by layer.

    Steps are not wrapped: a chain never crosses a joint limit. One step of size `step_limit` in one joint costs 1.
    """

    def __init__(self, step_limit: float) -> None:
        self._limit = step_limit
        self._layer, self._cost = np.zeros((0, 0)), np.zeros(0)
        self._origins: list[NDArray[np.int64]] = []

    def extend(self, layer: Floats, cost: Floats) -> bool:
        """Adds a layer (m, n) and its node costs (m,), unless no chain reaches it: then nothing is added and False returned."""
        from ._chain_kernels import extend_chain

        origin = np.full(len(layer), -1)
        new_cost = np.array(cost)
        if self._origins and not extend_chain(
            self._layer, self._cost, layer, np.ascontiguousarray(cost), self._limit**-2, self._limit, new_cost, origin
        ):
            return False
        self._layer, self._cost = layer, new_cost
        self._origins.append(origin)
        return True

    def gap(self, layer: Floats) -> float:
        """The largest joint step from the last layer to `layer` (m, n) on the chain where that is smallest."""
        reached = self._layer[np.isfinite(self._cost)]
        return min(float(np.abs(layer - q).max(axis=1).min()) for q in reached)

    def indices(self) -> NDArray[np.int64]:
        """The configuration of each layer on the cheapest chain."""
        found = [int(np.argmin(self._cost))]
        for origin in reversed(self._origins[1:]):
            found.append(int(origin[found[-1]]))
        return np.array(found[::-1])
