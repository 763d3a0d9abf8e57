"""A joint too many at the root of a chain: the base that gives a closed form is named."""

from horosphere import kinematics, robots

JOINTS = ["1 0 0", "0 0 1", "0 1 0", "1 0 0", "0 1 0", "1 0 0", "0 1 0", "0 0 1"]
PLACES = ["0 0 0", "0.1 0.2 0.3", "0 0 0", "0 0 0", "0.3 0 0", "0.25 0 0", "0 0 0", "0 0 0"]


def test_a_base_with_a_closed_form_is_named(tmp_path):
    text = ['<robot name="r"><link name="k0"/>']
    for i, (axis, place) in enumerate(zip(JOINTS, PLACES, strict=True)):
        text.append(
            f'<link name="k{i + 1}"/><joint name="j{i}" type="revolute"><parent link="k{i}"/><child link="k{i + 1}"/>'
            f'<origin xyz="{place}"/><axis xyz="{axis}"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>'
        )
    (tmp_path / "r.urdf").write_text("".join([*text, "</robot>"]))
    whole = kinematics.classify(robots.load(tmp_path / "r.urdf"))
    part = kinematics.classify(robots.load(tmp_path / "r.urdf", base="k1"))
    assert part.is_closed_form and not whole.is_closed_form
    assert f"with --base k1 (7 joints): {part.name}" in str(whole)
