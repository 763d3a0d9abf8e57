"""The tracer against an independent algebra: clifford's products in the orthonormal basis."""

import clifford
import numpy as np
import pytest

from horosphere.kernels import MV, blade, kernel, minimum, scalars
from horosphere.kernels._blades import product
from horosphere.kernels._graph import Graph

LAYOUT, BLADES = clifford.Cl(4, 1)


def as_clifford(mv):
    """A multivector in the null basis, by clifford: e0 = (e5 - e4)/2, ei = e4 + e5, blades by outer products."""
    vectors = [BLADES["e1"], BLADES["e2"], BLADES["e3"], (BLADES["e5"] - BLADES["e4"]) / 2, BLADES["e4"] + BLADES["e5"]]
    total = 0 * LAYOUT.scalar
    for b, c in mv.terms.items():
        element = LAYOUT.scalar
        for k, v in enumerate(vectors):
            if b >> k & 1:
                element = element ^ v
        total = total + c * element
    return total


def random_multivector(rng):
    return MV({b: float(c) for b, c in enumerate(rng.normal(size=32))})


@pytest.mark.parametrize("seed", range(5))
def test_products_agree_with_clifford(seed):
    rng = np.random.default_rng(seed)
    a, b = random_multivector(rng), random_multivector(rng)
    x, y = as_clifford(a), as_clifford(b)
    for ours, theirs in ((a * b, x * y), (a ^ b, x ^ y), (~a, ~x), (a - b, x - y)):
        np.testing.assert_allclose(as_clifford(ours).value, theirs.value, atol=1e-12)


def test_inner_product_is_the_lowest_grade_part():
    rng = np.random.default_rng(0)
    for r in range(1, 6):
        for s in range(1, 6):
            a = random_multivector(rng).only([b for b in range(32) if b.bit_count() == r])
            b = random_multivector(rng).only([b for b in range(32) if b.bit_count() == s])
            expected = (as_clifford(a) * as_clifford(b))(abs(r - s))
            np.testing.assert_allclose(as_clifford(a | b).value, expected.value, atol=1e-12)


def test_null_basis_metric():
    e0, ei = blade("0"), blade("i")
    assert product(e0, e0) == () and product(ei, ei) == ()
    assert dict(product(e0, ei)) == {blade("0i"): 1.0, 0: -1.0}


def test_commutators_cancel_and_equal_terms_are_one_node():
    graph = Graph()
    a, b, c = (graph.add("in", k) for k in range(3))
    assert (a * b - b * a).value == 0.0
    assert ((a + b) * c - c * (b + a)).value == 0.0
    assert (a * b + c).index == (c + b * a).index
    assert (2 * a - 2 * b).index == ((a - b) * 2).index


def test_constants_fold():
    graph = Graph()
    a = graph.add("in", 0)
    assert (a * 0.0).value == 0.0
    assert (a - a + 3.0).value == 3.0
    assert minimum(2.0, 3.0) == 2.0


def test_source_is_python_that_computes_the_same():
    @kernel(2, x=scalars(3), y=None)
    def f(x, y):
        s = x[0] * x[1] - 2.0 * x[2]
        return [s * y + 1.0, s / y - x[0] - 3.0]

    namespace = {}
    exec(f.source(), namespace)
    rng = np.random.default_rng(3)
    x, y = rng.normal(size=3), float(rng.normal())
    np.testing.assert_allclose(namespace["f"](*x, y), [(s := x[0] * x[1] - 2 * x[2]) * y + 1, s / y - x[0] - 3])


def test_wrong_number_of_results_is_said():
    @kernel(3, x=scalars(2))
    def two(x):
        return [x[0], x[1]]

    with pytest.raises(TypeError, match="returns 2 numbers, 3 were declared"):
        _ = two.trace
