"""The dynamic programme against all chains tried one by one."""

import itertools

import numpy as np
import pytest

from horosphere.planning._arm import _may_mend
from horosphere.planning._chain import ChainSearch


def brute_force(layers, costs, limit):
    best, way = np.inf, None
    for chain in itertools.product(*(range(len(layer)) for layer in layers)):
        q = np.stack([layer[i] for layer, i in zip(layers, chain)])
        steps = np.diff(q, axis=0)
        if (np.abs(steps) > limit).any():
            continue
        cost = (steps**2).sum() / limit**2 + sum(c[i] for c, i in zip(costs, chain))
        if cost < best:
            best, way = cost, chain
    return way


@pytest.mark.parametrize("seed", range(20))
def test_cheapest_of_all_chains(seed):
    rng = np.random.default_rng(seed)
    layers = [rng.uniform(-1, 1, (rng.integers(1, 6), 3)) for _ in range(5)]
    costs = [rng.uniform(0, 1, len(layer)) for layer in layers]
    search = ChainSearch(1.1)
    through = all(search.extend(layer, cost) for layer, cost in zip(layers, costs))
    expected = brute_force(layers, costs, 1.1)
    assert through == (expected is not None)
    assert expected is None or tuple(search.indices()) == expected


def test_says_where_it_breaks():
    layers = [np.zeros((2, 2)), np.full((3, 2), 0.1), np.full((1, 2), 5.0), np.full((1, 2), 5.0)]
    search = ChainSearch(0.2)
    assert [search.extend(layer, np.zeros(len(layer))) for layer in layers] == [True, True, False, False]


def test_a_jump_to_another_branch_is_not_looked_at_ever_finer():
    assert _may_mend((0.4, 0.30), None), "once is always tried"
    assert _may_mend((0.4, 0.15), (0.4, 0.30)), "half of it is left: a continuous motion"
    assert _may_mend((0.6, 0.50), (0.4, 0.30)), "further on along the path"
    assert not _may_mend((0.4, 0.29), (0.4, 0.30)), "as large as before at the same place"


def test_says_how_large_the_step_is_that_is_missing():
    search = ChainSearch(0.2)
    assert search.extend(np.array([[0.0, 0.0], [3.0, 0.0]]), np.zeros(2))
    assert search.extend(np.array([[0.1, 0.0], [9.0, 0.0]]), np.zeros(2))
    assert not search.extend(np.array([[0.1, 0.7], [9.0, 0.0]]), np.zeros(2)), "[9, 0] was not reached itself"
    assert search.gap(np.array([[0.1, 0.7], [9.0, 0.0]])) == pytest.approx(0.7)
    assert list(search.indices()) == [0, 0], "what no chain reaches is not added"
