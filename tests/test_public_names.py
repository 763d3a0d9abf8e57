"""The public names are frozen: outside code imports them. And the import stays light."""

import subprocess
import sys

import pytest

import horosphere as hs

TOP = {
    "Circle", "HorosphereError", "InputError", "Line", "Motor", "Multivector", "Plane", "Point", "PointPair", "Reflector",
    "Rotor", "Scene", "Sphere", "Translator",
}  # fmt: skip
MODULES = {
    "algebra", "certify", "control", "distance", "entities", "errors", "fields", "io", "kernels", "kinematics",
    "maps", "planning", "robots", "scenes", "shapes", "snake", "sweeps", "versors",
}  # fmt: skip
MEMBERS = {
    "Point": "from_euclidean as_euclidean",
    "Sphere": "from_center_radius from_points center radius radius_squared",
    "Plane": "from_normal_distance from_points normal distance",
    "Line": "from_points from_point_direction direction moment",
    "Circle": "from_points from_center_normal_radius center normal radius radius_squared",
    "PointPair": "from_points points",
    "Rotor": "from_axis_angle as_matrix",
    "Translator": "from_vector as_matrix",
    "Reflector": "from_plane as_matrix",
    "Motor": "from_line_angle from_matrix exp log as_matrix interpolate",
    "Multivector": "coefficients grade inverse dual undual left_contraction",
}
ENTITY = "as_ipns as_opns from_ipns from_opns is_real distance_to angle_to __and__ isclose array shape"


def test_top_level_names():
    assert {name for name in dir(hs) if not name.startswith("_")} == TOP | MODULES
    for name in TOP - {"Scene"}:
        assert getattr(hs, name).__name__ == name
    with pytest.raises(AttributeError, match="no attribute 'Sfere'"):
        hs.Sfere  # noqa: B018


@pytest.mark.parametrize("name", MEMBERS)
def test_members(name):
    value = getattr(hs, name)
    extra = ENTITY.split() if name in ("Point", "Sphere", "Plane", "Line", "Circle", "PointPair") else []
    for member in MEMBERS[name].split() + extra:
        assert hasattr(value, member), member


def test_the_import_is_light():
    code = (
        "import sys, horosphere as hs; hs.Point, hs.Motor, hs.Multivector; "
        "heavy = {'scipy', 'numba', 'llvmlite', 'viser', 'trimesh', 'yourdfpy', 'matplotlib', 'toppra', 'cyclopts'}; "
        "print(sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
