"""The picture of a planar field, drawn without a display."""

import numpy as np
import pytest

from horosphere import maps
from horosphere.errors import InputError
from horosphere.fields import HarmonicField


@pytest.fixture
def axes():
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, ax = plt.subplots()
    yield ax
    plt.close(figure)


@pytest.mark.parametrize(
    "obstacles",
    [
        ([[2.0, 0.0], [1.0, 1.5]], [0.5, 0.3]),
        [maps.lobed([2, 0], 0.6, 0.3, 5), maps.ellipsoid([2, 2], [0.8, 0.2])],
        [maps.Joukowski.aerofoil(0.5, -0.05 + 0.05j, [1.5, 0.0])],
        [],
    ],
    ids=["balls", "stars", "aerofoil", "nothing"],
)
def test_what_is_in_the_picture(axes, obstacles):
    field = HarmonicField([-1.0, 0.2], obstacles, workspace=([-3, -3], [5, 4]))
    path = field.trace([3.8, 0.1])
    assert field.plot(path, ax=axes, resolution=60, lines=12, extent=(-4, 6, -4, 5)) is axes
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert "goal" in labels and "motion" in labels
    motion = next(line for line in axes.lines if line.get_label() == "motion")
    np.testing.assert_array_equal(np.stack(motion.get_data(), axis=-1), path.points)
    zones = len(field.world.radii)
    assert len(axes.patches) >= zones + 4  # outlines and walls
    if zones:
        saddles = next(line for line in axes.lines if line.get_label() == "unstable point")
        assert len(saddles.get_xdata()) == zones
    assert axes.get_xlim() == (-4.0, 6.0)


def test_a_field_of_space_shows_which_zones_count():
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    centers, radii = np.array([[2.2, 0, 0], [0, 1.5, 0], [0, 0, 1.5], [0, -9, 0]]), np.full(4, 0.9)
    field = HarmonicField([-1.6, -0.8, -0.3], (centers, radii), boundary=0.2)
    path = field.trace([4.6, 2.2, 1.0])
    ax = field.plot(path, lines=5, unit="rad")
    motion = next(line for line in ax.lines if line.get_label() == "motion")
    np.testing.assert_allclose(np.stack(motion.get_data_3d(), axis=-1), path.points)
    assert "rad" in ax.get_zlabel()
    upper, lower = (other for other in ax.figure.axes if other is not ax)
    named = {line.get_label(): line for line in upper.lines if not line.get_label().startswith("_")}
    assert set(named) == {"obstacle 0", "obstacle 1", "obstacle 2"}  # the far one never counts
    np.testing.assert_allclose(named["obstacle 0"].get_ydata(), np.linalg.norm(path.points - centers[0], axis=1) - 0.9)
    shown = np.isfinite(lower.lines[1].get_ydata())
    np.testing.assert_array_equal(shown, field.weights(path.points)[:, 1] > 0.0)
    plt.close(ax.figure)


def test_only_the_plane_and_space_are_drawn():
    with pytest.raises(InputError, match=r"R\^4"):
        HarmonicField([0, 0, 0, 0]).plot()
