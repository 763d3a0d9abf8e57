"""The cheapest continuous chain of configurations along a path, one a layer: dynamic programming."""

from __future__ import annotations

import numpy as np

from ..kernels import jit


@jit
def extend_chain(previous, previous_cost, current, node_cost, weight, step_limit, cost, origin):
    """One layer: cost (m,) and origin (m,) of the best way to each configuration `current` (m, n).

    A way from `previous` (k, n) is open where no joint moves by more than `step_limit`; it costs
    weight * sum(dq^2) + node_cost. cost is infinite and origin -1 where there is none. Returns how many are reached.
    """
    reached = 0
    for j in range(current.shape[0]):
        best, best_i = np.inf, -1
        for i in range(previous.shape[0]):
            if previous_cost[i] >= best:
                continue
            way, is_open = 0.0, True
            for c in range(current.shape[1]):
                d = current[j, c] - previous[i, c]
                if abs(d) > step_limit:
                    is_open = False
                    break
                way += d * d
            if is_open and previous_cost[i] + weight * way < best:
                best, best_i = previous_cost[i] + weight * way, i
        cost[j] = best + node_cost[j]
        origin[j] = best_i
        if best_i >= 0:
            reached += 1
    return reached
