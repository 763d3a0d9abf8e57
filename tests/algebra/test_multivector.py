"""The dense algebra against the clifford package, and its own values' manners."""

import copy
import pickle
import warnings

import numpy as np
import pytest

import horosphere as hs
from horosphere.algebra import Multivector, basis

GRADES = [(0,), (1,), (2,), (3,), (4,), (5,), (0, 2, 4), (1, 3, 5), (0, 1, 2, 3, 4, 5)]


@pytest.fixture(scope="module")
def layout():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        clifford = pytest.importorskip("clifford")
        return clifford.Cl(4, 1)[0]


def random_element(rng, grades, shape=()):
    return Multivector(rng.normal(size=(*shape, 32))).grade(*grades)


@pytest.fixture(scope="module")
def tables(layout):
    """clifford's own multiplication tables, [left, result, right]; used as they are, its operators take long to compile."""
    dense = {}
    for name in ("gmt", "omt", "imt", "lcmt"):
        sparse = getattr(layout, name)
        dense[name] = np.zeros((32, 32, 32))
        dense[name][tuple(sparse.coords)] = sparse.data
    return dense


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("right", GRADES)
@pytest.mark.parametrize("left", GRADES)
def test_products_agree_with_the_tables_of_clifford(tables, left, right, seed):
    rng = np.random.default_rng(seed)
    a, b = random_element(rng, left), random_element(rng, right)
    for ours, table in [(a * b, "gmt"), (a ^ b, "omt"), (a | b, "imt"), (a.left_contraction(b), "lcmt")]:
        theirs = np.einsum("i,ijk,k->j", a.coefficients, tables[table], b.coefficients)
        np.testing.assert_allclose(ours.coefficients, theirs, atol=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("right", GRADES)
@pytest.mark.parametrize("left", GRADES)
def test_operators_agree_with_clifford(layout, left, right, seed):
    rng = np.random.default_rng(seed)
    a, b = random_element(rng, left), random_element(rng, right)
    x, y = layout.MultiVector(value=np.array(a.coefficients)), layout.MultiVector(value=np.array(b.coefficients))
    for ours, theirs in [
        (a * b, x * y),
        (a ^ b, x ^ y),
        (a | b, x | y),
        (a.left_contraction(b), x.lc(y)),
        (~a, ~x),
        (a.involute(), x.gradeInvol()),
        (a + b, x + y),
        (a - b, x - y),
        (-a, -x),
        (a.commutator(b), (x * y - y * x) / 2),
        (a.dual(), x * layout.pseudoScalar.inv()),
    ]:
        np.testing.assert_allclose(ours.coefficients, theirs.value, atol=1e-13)


def test_reversion_and_involution_turn_the_order_and_the_sign_of_vectors():
    rng = np.random.default_rng(0)
    forward = backward = Multivector.scalar(1.0)
    for count in range(1, 6):
        v = Multivector.vector(rng.normal(size=5))
        forward, backward = forward * v, v * backward
        assert (~forward).isclose(backward)
        assert forward.involute().isclose((-1.0) ** count * forward)


def test_blade_order_is_that_of_clifford(layout):
    assert [n.removeprefix("e") for n in Multivector.NAMES[1:]] == [
        "".join(map(str, t)) for t in layout.bladeTupList[1:]
    ]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("shape", [(), (1,), (4,), (2, 3), (0,)])
def test_batches_are_the_single_products(shape, seed):
    rng = np.random.default_rng(seed)
    a, b = random_element(rng, range(6), shape), random_element(rng, range(6), shape)
    product, outer = (a * b).coefficients, (a ^ b).coefficients
    assert product.shape == (*shape, 32)
    for i in np.ndindex(shape):
        np.testing.assert_allclose(product[i], (a[i] * b[i]).coefficients if shape else product, atol=1e-13)
        np.testing.assert_allclose(outer[i], (a[i] ^ b[i]).coefficients if shape else outer, atol=1e-13)


def test_batches_broadcast():
    rng = np.random.default_rng(5)
    a, b = random_element(rng, range(6), (3, 1)), random_element(rng, range(6), (4,))
    assert (a * b).shape == (3, 4)
    np.testing.assert_allclose((a * b)[2, 1].coefficients, (a[2, 0] * b[1]).coefficients, atol=1e-13)


@pytest.mark.parametrize("seed", range(5))
def test_algebra_laws(seed):
    rng = np.random.default_rng(seed)
    a, b, c = (random_element(rng, range(6), (7,)) for _ in range(3))
    assert ((a * b) * c).isclose(a * (b * c)).all()
    assert ((a ^ b) ^ c).isclose(a ^ (b ^ c)).all()
    assert (~(a * b)).isclose(~b * ~a).all()
    assert a.dual().undual().isclose(a).all()
    assert (a * a.inverse()).isclose(Multivector.scalar(np.ones(7)), atol=1e-8).all()


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("count", [1, 2, 3, 4, 5])
def test_inverse_of_versors_and_blades(count, seed):
    rng = np.random.default_rng(seed)
    vectors = [Multivector.vector(rng.normal(size=5)) for _ in range(count)]
    versor, blade = vectors[0], vectors[0]
    for v in vectors[1:]:
        versor, blade = versor * v, blade ^ v
    for x in (versor, blade):
        assert (x * x.inverse()).isclose(Multivector.scalar(1.0), atol=1e-9)
        assert (3.0 * x / x).isclose(Multivector.scalar(3.0), atol=1e-9)


def test_constants_and_conventions():
    e0, ei, unit = basis.e0, basis.ei, Multivector.scalar(1.0)
    assert (ei | e0) == -unit
    assert (e0 * e0) == 0 * unit and (ei * ei) == 0 * unit
    assert (ei ^ e0) == basis.E and unit == basis.E * basis.E
    assert -unit == basis.I * basis.I and basis.Ie * basis.E == basis.I
    assert Multivector.from_null(e1=2.0, e0i=3.0, s=1.0) == 2.0 * basis.e1 + 3.0 * (e0 ^ ei) + 1.0
    assert (2.0 * basis.e1 + 3.0 * (e0 ^ ei)).null("e0i") == 3.0


def test_exponential_of_a_bivector_is_cosine_and_sine():
    theta = 0.7
    expected = np.cos(theta) + np.sin(theta) * Multivector.blade("e12")
    assert (theta * Multivector.blade("e12")).exp().isclose(expected, rtol=1e-14)
    assert (theta * Multivector.blade("e15")).exp().isclose(np.cosh(theta) + np.sinh(theta) * Multivector.blade("e15"))


def test_values_have_manners():
    a = Multivector(np.arange(64.0).reshape(2, 32))
    assert pickle.loads(pickle.dumps(a)) == a and copy.deepcopy(a) == a
    assert hash(pickle.loads(pickle.dumps(a))) == hash(a)
    assert (
        a != Multivector(np.zeros((2, 32)))
        and a != "a"
        and len(a) == 2
        and [x == y for x, y in zip(a, a)] == [True] * 2
    )
    with pytest.raises(ValueError):
        a.coefficients[0] = 1.0
    with pytest.raises(AttributeError):
        a.array = np.zeros(32)  # type: ignore[misc]
    assert repr(1.5 - 2 * basis.e1 + Multivector.blade("e23")) == "Multivector(1.5 - 2 e1 + e23)"
    assert "e_{23}" in Multivector.blade("e23")._repr_latex_()
    assert repr(a).startswith("Multivector[2]") and (0 * basis.e1)._text() == "0"
    np_left = np.array([1.0, 2.0]) * a
    assert isinstance(np_left, Multivector) and np_left[1] == 2.0 * a[1]


def test_the_input_array_stays_the_callers():
    mine = np.zeros(32)
    value = Multivector(mine)
    mine[0] = 5.0
    assert value.scalar_part == 0.0 and mine.flags.writeable


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Multivector(np.zeros(31)), "(..., 32)"),
        (lambda: Multivector(np.full(32, np.nan)), "index (0,)"),
        (lambda: Multivector("abc"), "numbers"),
        (lambda: Multivector.blade("e21"), "did you mean"),
        (lambda: basis.e1.grade(6), "0..5"),
        (lambda: basis.e0.inverse(), "inverse"),
        (lambda: basis.e1 / 0.0, "zero"),
        (lambda: basis.e1 * np.array([1.0, np.nan]), "finite"),
    ],
)
def test_bad_input_is_named(make, words):
    with pytest.raises(hs.errors.InputError) as caught:
        make()
    assert words in str(caught.value)
