"""Choose one configuration for every point of a path: the cheapest chain in which neighbours are close (never greedy)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Chain:
    """`indices[k]` is the configuration chosen of layer k; `broken_at` is the first layer that no chain reaches, or None."""

    indices: NDArray[np.int64]
    broken_at: int | None


def cheapest_chain(layers: Sequence[Floats], costs: Sequence[Floats], step_limit: float) -> Chain:
    """The chain through `layers` (each (m_k, n) configurations) of least sum of squared joint steps and node `costs`.

    Steps are not wrapped: a chain never crosses a joint limit. One step of size `step_limit` in one joint costs 1.
    """
    from ._chain_kernels import extend_chain

    cost, origins = np.array(costs[0]), []
    for k in range(1, len(layers)):
        new_cost, origin = np.empty(len(layers[k])), np.empty(len(layers[k]), dtype=np.int64)
        node_cost = np.ascontiguousarray(costs[k])
        if not extend_chain(layers[k - 1], cost, layers[k], node_cost, step_limit**-2, step_limit, new_cost, origin):
            return Chain(np.zeros(0, np.int64), k)
        cost = new_cost
        origins.append(origin)
    indices = [int(np.argmin(cost))]
    for origin in reversed(origins):
        indices.append(int(origin[indices[-1]]))
    return Chain(np.array(indices[::-1]), None)
