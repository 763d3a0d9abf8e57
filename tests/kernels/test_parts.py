"""Compiling sooner must change nothing: parts of kernels, and remembered types of operators."""

import operator
import os
import subprocess
import sys

import numpy as np
import pytest

from horosphere.kernels._parts import remembering

MODULE = """
import math, sys
import numpy as np
from horosphere.kernels import jit, on_compile

@jit(part=True, _nrt=False)
def longest(a, k):
    best = 0.0
    for i in range(a.shape[0]):
        best = max(best, abs(a[i, k]))
    return best, k + 1

@jit(part=True, _nrt=False)
def both(a, none):
    if none is not None:
        return longest(a, none)[0]
    return math.sqrt(longest(a, 0)[0] ** 2 + longest(a, 1)[0] ** 2)

@jit
def entry(a):
    return both(a, None)

@jit
def other(a):
    return both(a, 1) + longest(a, 0)[1]

compiled = []
on_compile(compiled.append)
a = np.array([[3.0, -1.0], [-2.0, 4.0]])
print(entry(a), other(a), *sorted(set(compiled) & {"entry", "other", "both", "longest"}))
"""


@pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="nothing is compiled")
def test_parts_are_compiled_into_their_callers_and_only_these_are_kept(tmp_path):
    file = tmp_path / "some_kernels.py"
    file.write_text(MODULE)
    environment = {**os.environ, "HOROSPHERE_CACHE": str(tmp_path / "cache")}
    said = [
        subprocess.run([sys.executable, file], env=environment, capture_output=True, text=True, check=True).stdout
        for _ in range(2)
    ]
    assert said == ["5.0 5.0 both entry longest other\n", "5.0 5.0\n"]
    kept = {path.name.split("-")[0].split(".")[1] for path in (tmp_path / "cache").rglob("*.nbc")}
    assert kept == {"entry", "other"}


OPERATORS = operator.add, operator.truediv, operator.pow, operator.lt, operator.and_, operator.getitem, max


@pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="nothing is compiled")
def test_a_remembered_type_is_what_numba_finds():
    """Every operator on pairs of numbers, arrays and tuples, in random order and twice: numba's own answer, or its refusal."""
    from numba.core import types
    from numba.core.registry import cpu_target

    context = cpu_target.typing_context
    context.refresh()
    plain = types.Function.get_call_type
    with remembering():
        remembered = types.Function.get_call_type
    assert types.Function.get_call_type is plain and remembered is not plain  # others' functions are compiled as ever
    matrix = types.Array(types.float64, 2, "C")
    kinds = [
        types.int64,
        types.uint8,
        types.float32,
        types.float64,
        types.boolean,
        types.literal(2),
        types.none,
        matrix,
    ]
    kinds += [types.Array(types.int64, 1, "A"), types.UniTuple(types.int64, 2), types.UniTuple(types.float64, 3)]
    asked = [(f, (a, b)) for f in OPERATORS for a in kinds for b in kinds] * 2
    found = 0
    for k in np.random.default_rng(1).permutation(len(asked)):
        f, arguments = asked[k]
        function = context.resolve_value_type(f)
        answers = []
        for ask in (plain, remembered):
            try:
                signature = ask(function, context, arguments, {})
                answers.append((signature, function.get_impl_key(signature)))
            except Exception as error:
                answers.append(type(error))
        assert answers[0] == answers[1], (f, arguments)
        found += isinstance(answers[0], tuple)
    assert found > len(asked) // 3
