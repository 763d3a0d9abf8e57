"""Lanes in memory: columns and records in single and double precision, calls through addresses."""

import numpy as np
import pytest

from horosphere.kernels import (
    address_of,
    call_compiled,
    jit,
    kernel,
    lane_mask_lt,
    load_columns,
    load_lanes,
    round_even,
    scalars,
    store_columns,
)

SIXTEEN = (0,) * 16
EIGHT = (0,) * 8


@pytest.mark.parametrize(("tag", "dtype"), [(SIXTEEN, np.float32), (EIGHT, np.float64), (EIGHT, np.float32)])
def test_columns_come_back_as_they_went(tag, dtype):
    @jit
    def turn_round(source, target):
        a, b, c = load_columns(source, 2, 3, tag)
        store_columns(target, 1, (c, a * 2.0, b))

    width = len(tag)
    source, target = np.arange(60, dtype=dtype), np.zeros(60, dtype)
    turn_round(source, target)
    a, b, c = (source[2 + k * width : 2 + (k + 1) * width] for k in range(3))
    np.testing.assert_array_equal(target[1 : 1 + 3 * width], np.concatenate([c, 2 * a, b]))
    assert target[0] == 0 and (target[1 + 3 * width :] == 0).all()


@kernel(2, x=scalars(2))
def rounded(x):
    return [round_even(x[0]), round_even(x[1] * 2.0)]


def test_round_to_even():
    x = np.array([[0.5, 0.25], [1.5, 0.75], [-2.5, -1.3], [3.2, 1e5]])
    expected = np.column_stack([np.rint(x[:, 0]), np.rint(2 * x[:, 1])])
    np.testing.assert_array_equal(rounded(x), expected)
    np.testing.assert_array_equal(rounded.reference(x), expected)


@jit
def count_below(values, limit, pair):
    weights, add = pair
    total = 0
    for i in range(0, len(values), 16):
        mask = lane_mask_lt(load_lanes(values, i, SIXTEEN), limit)
        while mask:
            total += mask & 1
            mask >>= 1
    return total * weights[0] + add


@jit
def through_the_address(address, values, limit, pair):
    return call_compiled(address, (values, limit, pair)) + 1000


def test_a_call_through_an_address_is_the_call():
    values, weights = np.random.default_rng(0).uniform(size=64).astype(np.float32), np.array([3, 0])
    address = address_of(count_below, values, 0.5, (weights, 1))
    for limit in (0.0, 0.3, 1.0):
        expected = int((values < limit).sum()) * 3 + 7
        assert through_the_address(address, values, limit, (weights, 7)) == expected + 1000
        assert count_below(values, limit, (weights, 7)) == expected


def test_only_functions_that_return_an_integer_have_an_address():
    @jit
    def half(x):
        return 0.5 * x

    from numba import config

    if config.DISABLE_JIT:
        pytest.skip("without a compiler a function stands for itself")
    with pytest.raises(TypeError, match="not int64"):
        address_of(half, 1.0)
