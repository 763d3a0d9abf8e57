"""The dynamic programme against all chains tried one by one."""

import itertools

import numpy as np
import pytest

from horosphere.planning._chain import cheapest_chain


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
    chain = cheapest_chain(layers, costs, step_limit=1.1)
    expected = brute_force(layers, costs, 1.1)
    if expected is None:
        assert chain.broken_at is not None
    else:
        assert tuple(chain.indices) == expected


def test_says_where_it_breaks():
    layers = [np.zeros((2, 2)), np.full((3, 2), 0.1), np.full((1, 2), 5.0), np.full((1, 2), 5.0)]
    assert cheapest_chain(layers, [np.zeros(len(layer)) for layer in layers], 0.2).broken_at == 2
