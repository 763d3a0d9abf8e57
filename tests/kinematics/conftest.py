"""Robots under test: real URDFs where they are present, and random ones."""

import pytest
from robots_for_tests import Pinocchio, random_urdf

from horosphere import robots

CASES = ("panda", "nao", *(f"random-{seed}" for seed in range(3)))


@pytest.fixture(scope="session", params=CASES)
def urdf_robot(request, tmp_path_factory):
    """(our robot, the same in pinocchio)"""
    pytest.importorskip("pinocchio")
    name = request.param
    if name == "panda":
        path = request.getfixturevalue("shared_data") / "panda_spheres.urdf"
        robot = robots.load(path, tip="panda_hand")
    elif name == "nao":
        path = request.getfixturevalue("shared_data") / "nao.urdf"
        robot = robots.load(path, base="torso", tip="l_gripper")
    else:
        path = tmp_path_factory.mktemp("urdf") / f"{name}.urdf"
        robot = robots.load(path, tip=random_urdf(int(name.split("-")[1]), path))
    return robot, Pinocchio(path, robot)
