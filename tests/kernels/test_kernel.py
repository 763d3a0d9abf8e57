"""Compiled kernels against the numpy back end and plain numpy: every batch shape, record length, memory layout."""

import os
import subprocess
import sys

import numpy as np
import pytest
from numba import config

from horosphere.errors import InputError
from horosphere.kernels import (
    E0,
    EUCLIDEAN,
    MOTOR,
    VECTOR,
    apply_motor,
    atan2,
    cache_folder,
    kernel,
    scalars,
    sincos,
)  # fmt: skip

compiled_only = pytest.mark.skipif(bool(config.DISABLE_JIT), reason="about compiled code")


@kernel(MOTOR, a=MOTOR, b=MOTOR)
def product(a, b):
    return a * b


@kernel(EUCLIDEAN, m=MOTOR, p=EUCLIDEAN)
def move_point(m, p):
    return apply_motor(m, p + E0, EUCLIDEAN)


@kernel(VECTOR, m=MOTOR, x=VECTOR)
def sandwich(m, x):
    return m * x * ~m


@kernel(2, x=None)
def sine_cosine(x):
    return sincos(x)


@kernel(1, y=None, x=None)
def angle(y, x):
    return [atan2(y, x)]


BATCHES = [(), (1,), (3,), (8,), (9,), (100,), (2, 3), (0,), (4, 1, 5)]


@pytest.mark.parametrize("batch", BATCHES, ids=str)
@pytest.mark.parametrize("seed", [0, 1])
def test_compiled_equals_reference(batch, seed):
    rng = np.random.default_rng(seed)
    a, b = rng.normal(size=(2, *batch, 8))
    np.testing.assert_allclose(product(a, b), product.reference(a, b), atol=1e-13)
    out = np.empty((*batch, 8))
    assert product(a, b, out=out) is out
    np.testing.assert_array_equal(out, product(a, b))


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ((), (11,)),
        ((11,), ()),
        ((1, 1), (2, 9)),
        ((4, 1), (1, 5)),
        ((3,), (2, 1)),
        ((1, 1), (3,)),
        ((3,), (1, 1)),
        ((1,), ()),
    ],
)
def test_leading_axes_broadcast(left, right):
    rng = np.random.default_rng(0)
    m, p = rng.normal(size=(*left, 8)), rng.normal(size=(*right, 3))
    for _ in range(2):  # the second time without a detour
        result = move_point(m, p)
        assert result.shape == (*np.broadcast_shapes(left, right), 3)
        np.testing.assert_allclose(result, move_point.reference(m, p), atol=1e-12)


@pytest.mark.parametrize("width", [1, 2, 3, 5, 6, 7, 8, 9, 11, 16, 20, 31])
@pytest.mark.parametrize("count", [1, 7, 8, 25])
def test_records_of_any_length(width, count):
    @kernel(width, x=scalars(width))
    def affine(x):
        return [2.0 * v + k for k, v in enumerate(x)]

    x = np.random.default_rng(width).normal(size=(count, width))
    np.testing.assert_array_equal(affine(x), 2.0 * x + np.arange(width))


def test_other_layouts_are_taken():
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(2, 20, 8))
    expected = product(a, b)
    np.testing.assert_array_equal(product(np.asfortranarray(a), b), expected)
    np.testing.assert_array_equal(product(a[::2], b[::2]), expected[::2])
    np.testing.assert_array_equal(product(a[0].tolist(), b[0]), expected[0])
    frozen = a.copy()
    frozen.flags.writeable = False
    np.testing.assert_array_equal(product(frozen, b), expected)
    np.testing.assert_allclose(product(a[0].astype(np.float32), b[0]), product(a[0].astype(np.float32) * 1.0, b[0]))


def test_result_may_overwrite_an_argument():
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(2, 19, 8))
    expected = product(a, b)
    product(a, b, out=a)
    np.testing.assert_array_equal(a, expected)


@kernel(4, x=scalars(6))
def narrowed(x):
    """Fewer numbers out than in, in another order."""
    return [x[5] - x[0], x[4], x[1] + x[2], x[3]]


@pytest.mark.parametrize("batch", [1, 7, 8, 9, 40])
def test_result_may_overlap_an_argument(batch):
    rng = np.random.default_rng(batch)
    for _ in range(60):
        shared, b = rng.normal(size=8 * batch + 80), rng.normal(size=(batch, 8))
        at, to = rng.integers(0, 80, size=2)
        a, out = (shared[k : k + 8 * batch].reshape(batch, 8) for k in (at, to))
        expected = product(a.copy(), b)
        product(a, b, out=out)
        np.testing.assert_array_equal(out, expected)
        x, out = (shared[k : k + w * batch].reshape(batch, w) for k, w in ((at, 6), (to, 4)))
        expected = narrowed(x.copy())
        narrowed(x, out=out)
        np.testing.assert_array_equal(out, expected)
    a = rng.normal(size=(batch, 8))
    expected = product(a[-1].copy(), a)
    product(a[-1], a, out=a)  # one record of the output serves the whole batch
    np.testing.assert_array_equal(a, expected)


def test_half_cost_sandwich_equals_the_product_for_unit_motors():
    rng = np.random.default_rng(0)
    angle_, t = rng.normal(size=50), rng.normal(size=(50, 3))
    rotation = np.zeros((50, 8))
    rotation[:, 0], rotation[:, 2] = np.cos(angle_), np.sin(angle_)
    shift = np.zeros((50, 8))
    shift[:, 0], shift[:, 4:7] = 1.0, t
    m = product(rotation, shift)
    x = np.zeros((50, 5))
    x[:, :3] = rng.normal(size=(50, 3))
    x[:, 3], x[:, 4] = 1.0, 0.5 * (x[:, :3] ** 2).sum(-1)
    np.testing.assert_allclose(move_point(m, x[:, :3]), sandwich(m, x)[:, :3], atol=1e-13)


def test_sincos_and_atan2():
    rng = np.random.default_rng(0)
    x = np.concatenate([rng.uniform(-10, 10, 10_000), rng.uniform(-1e6, 1e6, 10_000), np.arange(-20, 21) * np.pi / 4])
    np.testing.assert_allclose(sine_cosine(x), np.stack([np.sin(x), np.cos(x)], -1), atol=4.5e-16, rtol=0)
    y, x = rng.normal(size=(2, 20_000)) * 10.0 ** rng.uniform(-8, 8, (2, 20_000))
    np.testing.assert_allclose(angle(y, x)[:, 0], np.arctan2(y, x), rtol=5e-16)
    for y, x in ((0, 0), (0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (-1, -1)):
        assert angle(y, x)[0] == pytest.approx(np.arctan2(y, x), abs=1e-16)


def test_nan_stays_nan():
    assert np.isnan(sine_cosine(np.array([np.nan, np.inf]))).all()


def test_wrong_shapes_are_named():
    with pytest.raises(InputError, match=r"b: expected shape \(\.\.\., 8\), got \(7,\)"):
        product(np.zeros(8), np.zeros(7))
    with pytest.raises(InputError, match="expected 2 arrays"):
        product(np.zeros(8))
    with pytest.raises(InputError, match="out: expected a writable"):
        product(np.zeros((3, 8)), np.zeros((3, 8)), out=np.zeros((3, 7)))


def test_inline_serves_compiled_loops():
    from horosphere.kernels import EIGHT, ONE, jit, lane_mask_lt, load_records, store_records, sum_lanes

    inline = product.inline

    @jit
    def squares(a, out, mask):
        whole = a.shape[0] // 8 * 8
        for i in range(0, whole, 8):
            m = load_records(a, i, 8, EIGHT)
            store_records(out, i, inline(*m, *m))
            mask[0] = lane_mask_lt(m[0], 0.0)
            mask[1] = sum_lanes(m[0])
        for i in range(whole, a.shape[0]):
            m = load_records(a, i, 8, ONE)
            store_records(out, i, inline(*m, *m))

    a = np.random.default_rng(0).normal(size=(11, 8))
    out, mask = np.empty_like(a), np.empty(2)
    squares(a, out, mask)
    np.testing.assert_allclose(out, product.reference(a, a), atol=1e-13)
    assert int(mask[0]) == sum(1 << k for k in range(8) if a[k, 0] < 0)
    assert mask[1] == pytest.approx(a[:8, 0].sum())


@compiled_only
def test_machine_code_can_be_read():
    assert "fmuladd" in sine_cosine.llvm() or "fmul" in sine_cosine.llvm()


SCRIPT = """
import os, sys
import numpy as np
from horosphere.kernels import MOTOR, kernel, on_compile
on_compile(lambda name: print("compiling", name))
@kernel(MOTOR, a=MOTOR, b=MOTOR)
def cached_product(a, b):
    return a * b
print(cached_product(np.arange(8.0), np.ones(8)).tolist())
"""


def run_script(**environment):
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, env=os.environ | environment)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@compiled_only
def test_disk_cache_serves_the_second_process(tmp_path):
    first = run_script(HOROSPHERE_CACHE=str(tmp_path))
    second = run_script(HOROSPHERE_CACHE=str(tmp_path))
    assert first[:2] == ["compiling cached_product", "compiling direct_call"] and first[2:] == second


@compiled_only
def test_works_where_nothing_can_be_written(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    assert run_script(HOROSPHERE_CACHE=str(blocked / "below"))[0] == "compiling cached_product"


def test_works_where_the_disk_is_full(monkeypatch, tmp_path):
    from numba.core.caching import IndexDataCacheFile

    from horosphere.kernels import jit

    def full(*arguments):
        raise OSError(28, "No space left on device")

    monkeypatch.setenv("HOROSPHERE_CACHE", str(tmp_path))
    monkeypatch.setattr(IndexDataCacheFile, "save", full)
    assert jit(lambda x: 2.0 * x + 1.0)(3.0) == 7.0


def test_works_without_a_compiler():
    assert run_script(NUMBA_DISABLE_JIT="1") == run_script()[-1:]


def test_cache_folder_follows_the_environment(monkeypatch, tmp_path):
    monkeypatch.setenv("HOROSPHERE_CACHE", str(tmp_path))
    assert cache_folder() == tmp_path


def test_the_stamp_of_compiled_code_covers_what_it_calls_and_no_more(monkeypatch, tmp_path):
    """A changed callee two modules away gives another stamp; a neighbour in the same package does not."""
    from horosphere.kernels import _cache

    files = {
        "arm/__init__.py": "from ._plan import plan",
        "arm/_plan.py": "from . import _solve",
        "arm/_solve.py": "from . import _joint as joint\nfrom ..shapes import distance",
        "arm/_joint.py": "turn = 1",
        "shapes/__init__.py": "from ._pair import distance",
        "shapes/_pair.py": "distance = 1",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.setattr(_cache, "PACKAGE", tmp_path)
    module = f"{tmp_path.name}.arm._solve"

    def stamp():
        for cached in (_cache.source_stamp, _cache._source_and_imports, _cache._source_file):
            cached.cache_clear()
        return _cache.source_stamp(module)

    first = stamp()
    try:
        for name, counts in {"arm/_joint.py": True, "shapes/_pair.py": True, "arm/_plan.py": False}.items():
            (tmp_path / name).write_text(files[name] + "\nmore = 2")
            assert (stamp() != first) == counts, name
            (tmp_path / name).write_text(files[name])
    finally:
        for cached in (_cache.source_stamp, _cache._source_and_imports, _cache._source_file):
            cached.cache_clear()
