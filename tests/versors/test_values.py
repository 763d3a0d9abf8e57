"""What every value does, entity or versor: copies, pickles, compares, prints, indexes, refuses bad input by name."""

import copy
import pickle

import numpy as np
import pytest
from entities.samples import KINDS

import horosphere as hs
from versors.test_versors import VERSORS

MAKERS = {**KINDS, **VERSORS}
SHAPES = [(), (1,), (4,), (2, 3), (0,)]


@pytest.mark.parametrize("shape", SHAPES, ids=str)
@pytest.mark.parametrize("kind", MAKERS)
def test_values_copy_pickle_and_compare(kind, shape):
    x = MAKERS[kind](np.random.default_rng(0), shape)
    for y in (copy.copy(x), copy.deepcopy(x), pickle.loads(pickle.dumps(x)), type(x)(x.array)):
        assert y == x and hash(y) == hash(x) and type(y) is type(x) and not y.array.flags.writeable
    assert x.isclose(x).all() and x.isclose(x).shape == shape == x.shape
    other = MAKERS[kind](np.random.default_rng(1), shape)
    assert (x != other or 0 in shape) and x != 3 and (x == None) is False  # noqa: E711
    assert x != x.broadcast_to((2, *shape))
    assert not x.isclose(other).any()
    assert len({x, copy.copy(x)}) == 1


@pytest.mark.parametrize("kind", MAKERS)
def test_values_index_iterate_and_reshape(kind):
    x = MAKERS[kind](np.random.default_rng(0), (2, 3))
    assert len(x) == 2 and x.ndim == 2 and x.size == 6 and x[1].shape == (3,) and x[:, 1].shape == (2,)
    assert [y.shape for y in x] == [(3,), (3,)] and [y for row in x for y in row] == [
        x[i, j] for i in (0, 1) for j in range(3)
    ]
    assert x[..., 0] == x[:, 0] and x[np.array([True, False])].shape == (1, 3)
    assert x.reshape(6)[4] == x[1, 1] and x.reshape((3, 2)).shape == (3, 2)
    assert type(x).stack([x[0], x[1]]) == x and type(x).stack([x[:, j] for j in range(3)], axis=-1) == x
    single = x[0, 0]
    assert single[()] == single
    for bad in (lambda: len(single), lambda: single[0], lambda: iter(single)):
        with pytest.raises(TypeError):
            bad()
    with pytest.raises(IndexError):
        x[2]
    with pytest.raises(hs.InputError, match="values"):
        type(x).stack([x, 3])


@pytest.mark.parametrize("kind", MAKERS)
def test_values_print(kind):
    for shape in SHAPES:
        x = MAKERS[kind](np.random.default_rng(0), shape)
        text, latex = repr(x), x._repr_latex_()
        assert text.startswith(kind) and len(text) < 400 and latex.startswith("$") and latex.endswith("$")
        if shape == ():
            assert "e_{" in latex


def test_repr_is_readable():
    assert repr(hs.Point.from_euclidean([1, 2.5, 0])) == "Point([1, 2.5, 0])"
    assert repr(hs.Sphere.from_center_radius([1, 2, 3], 2)) == "Sphere(center=[1, 2, 3], radius=2)"
    assert repr(hs.Line.from_points([0, 0, 1], [2, 0, 1])) == "Line(point=[0, 0, 1], direction=[1, 0, 0])"
    assert repr(hs.Motor.from_translation([1, 0, 0])) == "Motor(rotation=[0, 0, 0], translation=[1, 0, 0])"
    assert repr(hs.Rotor.from_axis_angle([0, 0, 2], 0.5)) == "Rotor(axis=[0, 0, 1], angle=0.5)"
    assert hs.Point.from_euclidean([0, 0, 2])._repr_latex_() == r"$\displaystyle 2\,e_{3} + e_{0} + 2\,e_{\infty }$"


@pytest.mark.parametrize("kind", MAKERS)
def test_values_are_frozen_and_own_their_numbers(kind):
    x = MAKERS[kind](np.random.default_rng(0), (2,))
    with pytest.raises(AttributeError):
        x.array = x.array
    with pytest.raises(ValueError):
        x.array[0, 0] = 1.0
    mine = np.array(x.array)
    y = type(x)(mine)
    mine[:] = 9
    assert y == x and mine.flags.writeable


@pytest.mark.parametrize("given", [[1, 2, 3], (1, 2, 3), np.array([1, 2, 3], np.int32), np.arange(1, 7, 2)[::1] * 1.0,
                                   np.array([1, 2, 3], np.float32), np.arange(6.0)[::2], range(3)], ids=str)  # fmt: skip
def test_anything_numpy_takes(given):
    x = np.array(given, float)
    assert (hs.Point.from_euclidean(given).as_euclidean() == x).all()
    assert (hs.Translator.from_vector(given).as_vector() == x).all()
    assert (hs.Sphere.from_center_radius(given, 1).center == x).all()
    assert hs.Line.from_points(hs.Point.from_euclidean(given), [9, 9, 9]) == hs.Line.from_points(given, [9, 9, 9])


def test_constructors_leave_the_callers_arrays_alone():
    xyz = np.array([1.0, 2.0, 3.0])
    for x in (hs.Point.from_euclidean(xyz), hs.Translator.from_vector(xyz), hs.Sphere.from_center_radius(xyz, 0.0)):
        before = x.array.copy()
        xyz += 1.0
        assert (x.array == before).all()


NAN = [0.0, np.nan, 1.0]
BAD = {
    "shape": (lambda: hs.Point.from_euclidean([1, 2]), "xyz: expected shape (..., 3), got (2,)"),
    "scalar": (lambda: hs.Point.from_euclidean(1.0), "expected shape (..., 3), got ()"),
    "nan": (lambda: hs.Point.from_euclidean(NAN), "xyz: expected finite numbers, got nan at index (1,)"),
    "nan single": (lambda: hs.Point.from_euclidean(np.array(NAN)), "got nan at index (1,)"),
    "inf": (lambda: hs.Point.from_euclidean(np.array([0, np.inf, 0])), "got inf at index (1,)"),
    "text": (lambda: hs.Point.from_euclidean("abc"), "expected numbers, got text"),  # type: ignore
    "numbers as text": (lambda: hs.Point.from_euclidean(["1", "2", "3"]), "expected numbers, got text"),  # type: ignore
    "complex": (lambda: hs.Point.from_euclidean(np.array([1j, 0, 0])), "complex numbers (complex128)"),  # type: ignore
    "masked": (lambda: hs.Point.from_euclidean(np.ma.array([1.0, 2, 3], mask=[0, 1, 0])), "masked elements"),
    "none": (lambda: hs.Point.from_euclidean(None), "expected numbers, got None"),  # type: ignore
    "radius": (lambda: hs.Sphere.from_center_radius([0, 0, 0], -1.0), "expected a radius >= 0, got -1.0"),
    "radius at": (lambda: hs.Sphere.from_center_radius(np.zeros((3, 3)), [1, 1, -2]), "got -2.0 at index (2,)"),
    "circle radius": (lambda: hs.Circle.from_center_normal_radius([0, 0, 0], [0, 0, 1], -1), "radius >= 0"),
    "batches": (lambda: hs.Sphere.from_center_radius(np.zeros((3, 3)), np.ones(4)), "center (3,), radius (4,)"),
    "normal": (lambda: hs.Plane.from_normal_distance([0, 0, 0], 1), "normal has length zero"),
    "plane collinear": (lambda: hs.Plane.from_points([0, 0, 0], [0.1, 0.1, 0.1], [0.3, 0.3, 0.3]), "not collinear"),
    "circle collinear": (lambda: hs.Circle.from_points([0, 0, 0], [1, 1, 1], [2, 2, 2]), "not collinear"),
    "circle twice": (lambda: hs.Circle.from_points([0, 0, 0], [1, 1, 1], [0, 0, 0]), "two coincide"),
    "line": (lambda: hs.Line.from_points([1, 2, 3], [1, 2, 3]), "a Line needs two different points"),
    "direction": (lambda: hs.Line.from_point_direction([1, 2, 3], [0, 0, 0]), "direction has length zero"),
    "pair": (lambda: hs.PointPair.from_points([1, 2, 3], [1, 2, 3]), "two different points"),
    "sphere": (lambda: hs.Sphere.from_points(*np.eye(3), [1 / 3, 1 / 3, 1 / 3]), "not in one plane"),
    "axis": (lambda: hs.Rotor.from_axis_angle([0, 0, 0], 1), "axis has length zero"),
    "screw": (lambda: hs.Motor.exp([1, 2, 3]), "screw: expected shape (..., 6), got (3,)"),
    "matrix shape": (lambda: hs.Motor.from_matrix(np.eye(3)), "expected shape (..., 4, 4), got (3, 3)"),
    "matrix": (lambda: hs.Motor.from_matrix(2 * np.eye(4)), "last row"),
    "scaled": (lambda: hs.Motor.from_matrix(np.diag([2.0, 1, 1, 1])), "R^T R = 1"),
    "mirror": (lambda: hs.Motor.from_matrix(np.diag([-1.0, 1, 1, 1])), "determinant -1"),
    "rotor": (lambda: hs.Rotor.from_matrix(np.zeros((3, 3))), "R^T R = 1"),
    "line type": (lambda: hs.Motor.from_line_angle([0, 0, 1], 1.0), "expected a Line, got list"),  # type: ignore
    "plane type": (lambda: hs.Reflector.from_plane([0, 0, 1, 0]), "expected a Plane, got list"),  # type: ignore
    "motor array": (lambda: hs.Motor(np.ones(8)), "expected a unit motor"),
    "point array": (lambda: hs.Point(np.ones(5)), "Point.from_euclidean"),
    "plane array": (lambda: hs.Plane(np.ones(4)), "unit normal"),
    "operand": (lambda: hs.Motor.identity() @ np.ones(3), "Point.from_euclidean"),
    "operands": (lambda: hs.Motor.identity((2,)) @ hs.Motor.identity((3,)), "broadcast"),
    "reflect a motor": (lambda: hs.Reflector.from_plane(hs.Plane.from_normal_distance([0, 0, 1], 0)) @ hs.Motor.identity(),
                        "Reflector @ Motor is not defined"),
    "isclose": (lambda: hs.Motor.identity().isclose(hs.Point.origin()), "expected a Motor, got Point"),  # type: ignore
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_input_says_what_was_expected(case):
    make, words = BAD[case]
    with pytest.raises(hs.InputError) as caught:
        make()
    assert words in str(caught.value)


def test_the_first_bad_element_of_a_batch_is_named():
    a = np.random.default_rng(0).normal(size=(4, 5, 3))
    b = a + 1
    b[2, 3] = a[2, 3]
    with pytest.raises(hs.InputError, match=r"at index \(2, 3\)"):
        hs.Line.from_points(a, b)
