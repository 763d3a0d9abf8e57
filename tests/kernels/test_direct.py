"""Direct calls: built-ins that read arrays themselves. The plain case is served, everything else is left to the general way."""

import ctypes
import gc
import os
import re
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
from numba import config

from horosphere import InputError, Line, Motor, Point
from horosphere.kernels import MOTOR, Kernel, _direct, kernel, scalars

compiled_only = pytest.mark.skipif(bool(config.DISABLE_JIT), reason="direct calls need compiled code")


class Value:
    """A holder of an array as the typed values of upper layers are."""

    __slots__ = ("array",)

    def __init__(self, array):
        self.array = array


@kernel(MOTOR, a=MOTOR, b=MOTOR)
def product(a, b):
    return a * b


@kernel(3, finite=True, x=scalars(2), t=None)
def checked(x, t):
    return [x[0] * t, x[1] * t, t]


def two_outputs(x):
    return [x[0] + x[1], *(2.0 * v for v in x), *(3.0 * v for v in x)]


several = Kernel("several", two_outputs, {"x": scalars(2)}, 5, axes=[(1,), (2, 2)], finite=True)


@pytest.fixture(scope="module", autouse=True)
def compile_first():
    product(np.zeros(8), np.zeros(8))
    checked(np.zeros(2), np.zeros(()))
    several(np.zeros(2))


@compiled_only
@pytest.mark.parametrize("batch", [(), (1,), (5,), (2, 3), (0,), (3, 1, 9), (5000,), (1,) * 16])
def test_plain_arrays_are_served(batch):
    direct = product.direct([np.ndarray] * 2, [np.ndarray]).call
    a, b = np.random.default_rng(len(batch)).normal(size=(2, *batch, 8))
    expected = product.reference(a, b)
    result, out = direct(a, b), np.full((*batch, 8), np.nan)
    assert type(result) is np.ndarray and result.flags.owndata and result.flags.writeable
    np.testing.assert_allclose(result, expected, atol=1e-13)
    np.testing.assert_array_equal(direct(a, b, None), result)
    assert direct(a, b, out) is out
    np.testing.assert_array_equal(out, result)


def not_plain():
    good = np.ones((3, 8))
    frozen, unaligned = np.ones((3, 8)), np.zeros(3 * 64 + 1, np.uint8)[1:].view(np.float64).reshape(3, 8)
    frozen.setflags(write=False)
    tagged = np.ones((3, 8), np.dtype(np.float64, metadata={"a": 1}))
    cases = {
        "float32": (good.astype(np.float32), good),
        "integers": (good.astype(int), good),
        "other byte order": (good.astype(">f8"), good),
        "complex": (good.astype(complex), good),
        "objects": (good.astype(object), good),
        "dtype with metadata": (tagged, good),
        "fortran order": (np.asfortranarray(good), good),
        "strided": (np.ones((3, 16))[:, ::2], good),
        "backwards": (good[::-1], good),
        "unaligned": (unaligned, good),
        "subclass": (good.view(np.matrix), good),
        "masked": (np.ma.array(good), good),
        "list": (good.tolist(), good),
        "number": (1.0, good),
        "none": (None, good),
        "string": ("abc", good),
        "class": (np.ndarray, good),
        "too narrow": (np.ones((3, 7)), good),
        "other batch": (np.ones((4, 8)), good),
        "broadcast": (np.ones(8), good),
        "no axis": (np.array(1.0), good),
        "17 batch axes": (np.ones((1,) * 17 + (8,)), np.ones((1,) * 17 + (8,))),
        "one argument": (good,),
        "no argument": (),
        "four arguments": (good, good, good, good),
        "out read-only": (good, good, frozen),
        "out of another shape": (good, good, np.ones((3, 7))),
        "out float32": (good, good, np.ones((3, 8), np.float32)),
        "out in fortran order": (good, good, np.asfortranarray(np.ones((3, 8)))),
        "out a list": (good, good, [0.0] * 24),
    }
    return [pytest.param(arguments, id=name) for name, arguments in cases.items()]


@compiled_only
@pytest.mark.parametrize("arguments", not_plain())
def test_what_is_not_plain_is_left_alone(arguments):
    direct = product.direct([np.ndarray] * 2, [np.ndarray]).call
    before = [np.array(a, copy=True) if isinstance(a, np.ndarray) else a for a in arguments]
    assert direct(*arguments) is None
    for a, b in zip(arguments, before, strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("name", ["float32", "other byte order", "dtype with metadata", "fortran order", "strided",
                                  "unaligned", "subclass", "list", "broadcast", "17 batch axes"])  # fmt: skip
def test_the_general_way_takes_what_numpy_takes(name):
    a, b = next(case.values[0] for case in not_plain() if case.id == name)
    rng = np.random.default_rng(1)
    for x in (a, b):
        if isinstance(x, np.ndarray):
            x[...] = rng.normal(size=x.shape)
    np.testing.assert_allclose(product(a, b), product.reference(np.asarray(a), b), atol=1e-13)


@compiled_only
def test_values_go_in_and_come_out():
    direct = product.direct([Value, np.ndarray], [Value]).call
    a, b = np.random.default_rng(2).normal(size=(2, 4, 8))
    value = direct(Value(a), b)
    assert type(value) is Value and not value.array.flags.writeable and value.array.flags.owndata
    np.testing.assert_allclose(value.array, product.reference(a, b), atol=1e-13)
    out = np.empty((4, 8))
    view = direct(Value(a), b, out)
    assert view.array.base is out and out.flags.writeable and not view.array.flags.writeable
    np.testing.assert_array_equal(out, value.array)
    unset = object.__new__(Value)
    for wrong in (a, unset, Value([1.0] * 8), Value(None), Value(a[:, ::2])):
        assert direct(wrong, b) is None


def test_numbers_that_are_not_finite():
    x, t = np.ones((20, 2)), np.ones(20)
    for array, index, name in ((x, (17, 1), "x"), (t, 3, "t")):
        for bad in (np.nan, np.inf, -np.inf):
            array[index] = bad
            with pytest.raises(InputError, match=rf"{name}: expected finite numbers, got {bad}"):
                checked(x, t)
            array[index] = 1.0
    huge = np.full((3, 2), 1.5e308)  # finite, but their sum is not
    np.testing.assert_array_equal(checked(huge, np.ones(3))[:, :2], huge)


@pytest.mark.parametrize("batch", [(), (11,), (2, 9)])
def test_several_outputs(batch):
    x = np.random.default_rng(3).normal(size=(*batch, 2))
    first, second = several(x)
    assert first.shape == (*batch, 1) and second.shape == (*batch, 2, 2)
    np.testing.assert_allclose(first[..., 0], x.sum(-1), atol=1e-15)
    np.testing.assert_array_equal(second, np.stack([2.0 * x, 3.0 * x], axis=-2))
    outs = np.empty_like(first), np.empty_like(second)
    result = several(x, out=outs)
    assert result[0] is outs[0] and result[1] is outs[1]
    np.testing.assert_array_equal(outs[1], second)
    with pytest.raises(InputError, match="out: expected 2 arrays"):
        several(x, out=outs[:1])


@compiled_only
def test_one_record_for_a_whole_batch():
    from horosphere.kernels._direct import Direct

    a, b = np.random.default_rng(5).normal(size=(2, 6, 8))
    product(a[0], b)
    address, used = product._compiled[True, False]
    assert used.alone == (True, False)
    expected = product.reference(a[0], b)
    for one in (a[0], a[:1]):
        np.testing.assert_allclose(used.call(one, b), expected, atol=1e-13)
        np.testing.assert_allclose(used.call(one, b.reshape(2, 3, 8)), expected.reshape(2, 3, 8), atol=1e-13)
    for one in (
        a,
        a[:2],
        a[:1].reshape(1, 1, 8),
        a[0, :7],
    ):  # (1, 1) and (6,) broadcast to (1, 6): not this way's business
        assert used.call(one, b) is None
    every = Direct(used.inputs, used.outputs, (True, True))
    every.connect(address)
    assert every.call(a[0], b[0]) is None  # no batch to follow: never connected


@compiled_only
def test_references_balance():
    a, b, out = np.ones((3, 2, 8))
    value = Value(a)
    typed, plain = (
        product.direct([Value, np.ndarray], [Value]).call,
        product.direct([np.ndarray] * 2, [np.ndarray]).call,
    )
    pair = several.direct([np.ndarray], [Value, np.ndarray]).call
    x, bad, y, none, dtype = np.ones(2), np.array([np.nan, 1.0]), np.empty(1), None, np.dtype(np.float64)

    def work():
        typed(value, b), typed(value, b, out), plain(a, b), plain(a, b, out), plain(a, 1), typed(value, out[:, ::2])
        pair(x), pair(bad), pair(x, y, None)

    work()
    gc.collect()
    watched = [a, b, out, x, y, value, none, dtype, Value, np.ndarray]
    before = [sys.getrefcount(x) for x in watched]
    for _ in range(1000):
        work()
    gc.collect()
    after = [sys.getrefcount(x) for x in watched]
    assert all(abs(m - n) < 300 for m, n in zip(before, after, strict=True)), list(zip(before, after, strict=True))


def test_results_outlive_what_they_were_made_from():
    def motor():
        return Motor.exp(np.full(6, 0.1)) @ Motor.identity()

    kept = [motor() for _ in range(200)]
    gc.collect()
    assert all(m == kept[0] for m in kept)
    assert kept[0] @ Point.from_euclidean(np.zeros(3)) == kept[1] @ Point.from_euclidean(np.zeros(3))
    line = Line.from_points([0.0, 0, 0], [0.0, 0, 1])
    assert type(kept[0] @ line) is Line


@compiled_only
def test_other_threads_run_during_a_long_batch():
    a = np.ones((400_000, 8))
    steps, done = [0], threading.Event()

    def count():
        while not done.is_set():
            steps[0] += 1

    counter = threading.Thread(target=count)
    counter.start()
    try:
        for _ in range(10):
            product(a, a, out=a.copy())
    finally:
        done.set()
        counter.join()
    assert steps[0] > 0


@compiled_only
def test_the_guard_knows_this_numpy():
    """The indices into numpy's table of functions are those that its own header gives to extension modules."""
    header = Path(np.get_include(), "numpy", "__multiarray_api.h").read_text()
    for name, index in (
        ("PyArray_GetNDArrayCVersion", _direct._ABI_VERSION),
        ("PyArray_NewFromDescr", _direct._NEW_FROM_DESCR),
        ("PyArray_SetBaseObject", _direct._SET_BASE_OBJECT),
    ):
        found = re.search(rf"#define {name} \\\n\s*\(.*\\\n\s*PyArray_API\[(\d+)\]\)", header)
        assert found and int(found[1]) == index
    assert _direct.fields_are_where_expected()
    assert _direct.numpy_functions() is not None


def test_the_guard_sees_another_layout(monkeypatch):
    from horosphere.kernels import _trampoline

    for field in ("OBJECT_TYPE", "ARRAY_DATA", "ARRAY_AXES", "ARRAY_DTYPE", "ARRAY_FLAGS"):
        with monkeypatch.context() as patch:
            patch.setattr(_trampoline, field, getattr(_trampoline, field) - 8)
            assert not _direct.fields_are_where_expected(), field
    for field in ("CONTIGUOUS", "ALIGNED", "WRITEABLE"):
        with monkeypatch.context() as patch:
            patch.setattr(_trampoline, field, 0x2)
            assert not _direct.fields_are_where_expected(), field


@compiled_only
@pytest.mark.parametrize("reason", ["implementation", "free-threaded", "numpy", "no table"])
def test_without_the_layout_everything_goes_through_ctypes(monkeypatch, reason):
    if reason == "implementation":
        monkeypatch.setattr(_direct.sys, "implementation", type("I", (), {"name": "pypy"}))
    elif reason == "free-threaded":
        monkeypatch.setattr(_direct.sysconfig, "get_config_var", lambda name: 1)
    elif reason == "numpy":
        monkeypatch.setattr(_direct, "_NUMPY_ABI", 0x03000000)
    else:
        monkeypatch.setattr(_direct, "_numpy_table", lambda: (_ for _ in ()).throw(ImportError()))
    _direct.numpy_functions.cache_clear()
    try:
        assert _direct.numpy_functions() is None
        plain = kernel(MOTOR, a=MOTOR, b=MOTOR)(lambda a, b: a * b)
        plain.name = "product"
        pair = Kernel("several", two_outputs, {"x": scalars(2)}, 5, axes=[(1,), (2, 2)], finite=True)
        typed = plain.direct([Value] * 2, [Value])
        rng = np.random.default_rng(4)
        for left, right in (((), ()), ((9,), (9,)), ((), (9,)), ((2, 1), (1, 5))):
            a, b = rng.normal(size=(*left, 8)), rng.normal(size=(*right, 8))
            np.testing.assert_array_equal(plain(a, b), product(a, b))
        assert typed.call(Value(a), Value(b)) is None
        np.testing.assert_array_equal(pair(b[..., :2].copy())[1], several(b[..., :2].copy())[1])
        with pytest.raises(InputError, match="finite"):
            pair(np.array([np.nan, 0.0]))
    finally:
        monkeypatch.undo()
        _direct.numpy_functions.cache_clear()


SCRIPT = """
import numpy as np
from horosphere import Motor, Point, kinematics, robots
m = Motor.exp([0.1, 0.2, 0.3, 1.0, 2.0, 3.0])
for _ in range(2):
    p = (m @ m) @ Point.from_euclidean([1.0, 2.0, 3.0])
    pose, J = kinematics.forward_and_jacobian(robots.srs_arm(), np.full(7, 0.3))
    print(np.round(p.array, 12).tolist(), np.round(m.log(), 12).tolist(), np.round(pose.array, 12).tolist(), np.round(J, 12).sum())
"""


def test_the_same_without_a_compiler():
    """Public values and kinematics on the numpy back end equal the direct calls."""
    results = []
    for setting in ("0", "1"):
        environment = os.environ | {"NUMBA_DISABLE_JIT": setting}
        done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, env=environment)
        assert done.returncode == 0, done.stderr
        results.append(done.stdout.replace("-0.0,", "0.0,"))
    assert results[0] == results[1] and len(results[0].splitlines()) == 2


def test_a_method_definition_has_the_size_of_pythons():
    assert ctypes.sizeof(_direct._Method) == 4 * ctypes.sizeof(ctypes.c_void_p)
