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


def test_only_the_plane_is_drawn():
    with pytest.raises(InputError, match=r"R\^3"):
        HarmonicField([0, 0, 0]).plot()
