"""What `_lanes` does, in numpy: takes its place when numba's compiler is switched off (NUMBA_DISABLE_JIT=1)."""

from __future__ import annotations

import numpy as np

ONE = (0,)
EIGHT = (0,) * 8


def load_records(array, i, k, tag):
    flat = array.reshape(-1)[i * k : (i + len(tag)) * k].reshape(len(tag), k)
    return tuple(flat[0]) if len(tag) == 1 else tuple(flat.T.copy())


def store_records(array, i, values):
    width = max(np.size(v) for v in values)
    k = len(values)
    block = array.reshape(-1)[i * k : (i + width) * k].reshape(width, k)
    for c, value in enumerate(values):
        block[:, c] = value


def load_lanes(array, offset, tag):
    flat = array.reshape(-1)
    return flat[offset] if len(tag) == 1 else flat[offset : offset + len(tag)].copy()


def store_lanes(array, offset, value):
    array.reshape(-1)[offset : offset + np.size(value)] = value


def load_columns(array, offset, k, tag):
    return tuple(load_lanes(array, offset + c * len(tag), tag) for c in range(k))


def store_columns(array, offset, values):
    width = max(np.size(v) for v in values)
    for c, value in enumerate(values):
        array.reshape(-1)[offset + c * width : offset + (c + 1) * width] = value


def spread(value, tag):
    return value if len(tag) == 1 else np.full(len(tag), float(value))


min_lane, max_lane, sum_lanes = np.min, np.max, np.sum
lane_sqrt, lane_abs, lane_min, lane_max = np.sqrt, np.abs, np.minimum, np.maximum


def lane_where_lt(a, b, x, y):
    return np.where(np.less(a, b), x, y)


def lane_mask_lt(a, b):
    return int(sum(1 << k for k, below in enumerate(np.atleast_1d(np.less(a, b))) if below))
