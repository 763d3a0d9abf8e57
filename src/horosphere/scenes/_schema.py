"""The fields of a scene file, as pydantic models: one per kind of robot, target, obstacle, and per section."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag

Number = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Fraction = Annotated[float, Field(gt=0.0, le=1.0, allow_inf_nan=False)]
Vector = Annotated[list[Number], Field(min_length=2)]
Vector2 = Annotated[list[Number], Field(min_length=2, max_length=2)]
Vector3 = Annotated[list[Number], Field(min_length=3, max_length=3)]
Vector4 = Annotated[list[Number], Field(min_length=4, max_length=4)]


def _form(value: Any) -> str:
    return "<fields>" if isinstance(value, dict) else "<list>" if isinstance(value, list) else "<number>"


# One form is tried, not all: a wrong number in a list is one problem, not three.
Joints = Annotated[
    Annotated[list[Number], Tag("<list>")] | Annotated[dict[str, Number], Tag("<fields>")], Discriminator(_form)
]
Rates = Annotated[Annotated[Positive, Tag("<number>")] | Annotated[list[Positive], Tag("<list>")], Discriminator(_form)]
Numbers = Annotated[Annotated[Number, Tag("<number>")] | Annotated[list[Number], Tag("<list>")], Discriminator(_form)]
Radius = Annotated[
    Annotated[NotNegative, Tag("<number>")] | Annotated[dict[str, NotNegative], Tag("<fields>")], Discriminator(_form)
]
Radii = Annotated[
    Annotated[NotNegative, Tag("<number>")] | Annotated[list[NotNegative], Tag("<list>")], Discriminator(_form)
]
ArmRadius = Annotated[
    Annotated[NotNegative, Tag("<number>")]
    | Annotated[list[NotNegative], Field(min_length=3, max_length=3), Tag("<list>")],
    Discriminator(_form),
]
ROTATION = ("quaternion_wxyz", "rpy", "rpy_deg")


class Section(BaseModel):
    """Strict: no unknown field, no text where a number belongs.

    `one_of`: groups of fields of which exactly one is given; `at_most_one`: groups of which one may be.
    """

    model_config = ConfigDict(extra="forbid", strict=True)
    one_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    at_most_one: ClassVar[tuple[tuple[str, ...], ...]] = ()


# Robots ------------------------------------------------------------------------------------------------------------


class Arm(Section):
    at_most_one = (("lower", "lower_deg"), ("upper", "upper_deg"))
    lower: list[Number] | None = None
    upper: list[Number] | None = None
    lower_deg: list[Number] | None = None
    upper_deg: list[Number] | None = None
    velocity: Rates | None = None
    acceleration: Rates | None = None


class LoadedRobot(Arm):
    capsules: str | None = None
    link_radius: Radius | None = None


class NamedRobot(LoadedRobot):
    name: str


class FileRobot(LoadedRobot):
    file: str


class UrdfRobot(LoadedRobot):
    urdf: str
    base: str | None = None
    tip: str | None = None
    locked: dict[str, Number] | None = None
    srdf: str | None = None
    group: str | None = None
    collision: Literal["capsules", "spheres"] | None = None
    budget: Annotated[int, Field(ge=1)] | None = None
    tolerance: Positive | None = None
    geometry: Literal["auto", "collision", "visual"] | None = None


class MechanismFields(Arm):
    mechanism: str


class HumanoidArm(MechanismFields):
    mechanism: Literal["humanoid_arm"]
    d0: NotNegative
    h: Number
    d1: Positive
    d2: Positive
    d3: Positive
    link_radius: ArmRadius | None = None


class SrsArm(MechanismFields):
    mechanism: Literal["srs_arm"]
    dbs: NotNegative
    dse: Positive
    dew: Positive
    dwf: NotNegative
    link_radius: NotNegative | None = None


class SixAxisArm(MechanismFields):
    mechanism: Literal["six_axis_arm"]
    a1: Number
    d1: Number
    a2: Positive
    a3: Number
    d4: Positive
    d6: NotNegative
    link_radius: NotNegative | None = None


class Point(Section):
    type: Literal["point", "ball"]
    dimension: Annotated[int, Field(ge=2)] | None = None
    radius: NotNegative = 0.0
    unit: Literal["m", "rad"] = "m"
    max_speed: Positive = 1.0
    max_acceleration: Positive = 4.0


class Unicycle(Section):
    type: Literal["unicycle"]
    radius: NotNegative = 0.1
    max_speed: Positive = 1.0
    max_turn_rate: Positive = 2.0
    max_acceleration: Positive = 4.0


class Snake(Section):
    at_most_one = (("lengths", "links"), ("lengths", "length"))
    type: Literal["snake"]
    links: Annotated[int, Field(ge=3)] | None = None
    length: Positive | None = None
    lengths: Annotated[list[Positive], Field(min_length=3)] | None = None
    wheel_fraction: Annotated[float, Field(ge=0.0, le=1.0, allow_inf_nan=False)] = 0.5
    width: NotNegative = 0.0


MECHANISMS = {"humanoid_arm": HumanoidArm, "srs_arm": SrsArm, "six_axis_arm": SixAxisArm}
BODIES = {"point": Point, "ball": Point, "unicycle": Unicycle, "snake": Snake}

# Targets -----------------------------------------------------------------------------------------------------------


class JointFields(Section):
    one_of = (("joints", "joints_deg"),)
    joints: Joints | None = None
    joints_deg: Joints | None = None


class PositionFields(Section):
    position: Vector


class GripperPlaneFields(Section):
    position: Vector3
    plane_normal: Vector3


class PoseFields(Section):
    one_of = (ROTATION,)
    position: Vector3
    quaternion_wxyz: Vector4 | None = None
    rpy: Vector3 | None = None
    rpy_deg: Vector3 | None = None


class LineFields(Section):
    point: Vector3
    direction: Vector3


class OnLine(Section):
    line: LineFields


class PlaneFields(Section):
    one_of = (("distance", "point"),)
    normal: Vector3
    distance: Number | None = None
    point: Vector3 | None = None


class InPlane(Section):
    plane: PlaneFields


class HeadingFields(Section):
    at_most_one = (("heading", "heading_deg"),)
    position: Vector2
    heading: Number | None = None
    heading_deg: Number | None = None


class PostureFields(Section):
    one_of = (("heading", "heading_deg"), ("joints", "joints_deg"))
    position: Vector2
    heading: Number | None = None
    heading_deg: Number | None = None
    joints: list[Number] | None = None
    joints_deg: list[Number] | None = None


# Obstacles ---------------------------------------------------------------------------------------------------------


class Obstacle(Section):
    type: str
    name: str = ""


class Rotated(Obstacle):
    at_most_one = (ROTATION,)
    quaternion_wxyz: Vector4 | None = None
    rpy: Vector3 | None = None
    rpy_deg: Vector3 | None = None


class Angled(Obstacle):
    at_most_one = (("angle", "angle_deg"),)
    angle: Number | None = None
    angle_deg: Number | None = None


class Sphere(Obstacle):
    center: Vector
    radius: Positive


class Ellipsoid(Rotated):
    center: Vector
    semi_axes: Annotated[list[Positive], Field(min_length=2)]


class Ellipse(Angled):
    center: Vector2
    semi_axes: Annotated[list[Positive], Field(min_length=2, max_length=2)]


class AerofoilFields(Angled):
    center: Vector2
    k: Positive
    mu: Vector2


class StarFields(Angled):
    center: Vector2
    radius: Positive
    lobes: Annotated[int, Field(ge=1)] = 5
    amplitude: Annotated[float, Field(ge=0.0, lt=1.0, allow_inf_nan=False)] = 0.3


class Capsule(Obstacle):
    a: Vector3
    b: Vector3
    radius: Positive


class Cylinder(Obstacle):
    one_of = (("a", "center"), ("b", "axis"), ("b", "length"))
    a: Vector3 | None = None
    b: Vector3 | None = None
    center: Vector3 | None = None
    axis: Vector3 | None = None
    length: Positive | None = None
    radius: Positive


class Box(Rotated):
    center: Vector3
    size: Annotated[list[Positive], Field(min_length=3, max_length=3)]


class HalfSpace(Obstacle):
    one_of = (("distance", "point"),)
    normal: Vector3
    distance: Number | None = None
    point: Vector3 | None = None


class Mesh(Rotated):
    one_of = (("file", "vertices"), ("file", "faces"))
    file: str | None = None
    vertices: Annotated[list[Vector3], Field(min_length=3)] | None = None
    faces: Annotated[list[Annotated[list[int], Field(min_length=3, max_length=3)]], Field(min_length=1)] | None = None
    fill: Literal["solid", "hull", "surface"] = "solid"
    scale: Positive = 1.0
    position: Vector3 = [0.0, 0.0, 0.0]


class Points(Rotated):
    one_of = (("points", "file"),)
    points: Annotated[list[Vector3], Field(min_length=1)] | None = None
    file: str | None = None
    radius: Radii = 0.0
    scale: Positive = 1.0
    position: Vector3 = [0.0, 0.0, 0.0]


OBSTACLES: dict[str, type[Obstacle]] = {
    "sphere": Sphere,
    "ball": Sphere,
    "disk": Sphere,
    "ellipsoid": Ellipsoid,
    "ellipse": Ellipse,
    "aerofoil": AerofoilFields,
    "star": StarFields,
    "capsule": Capsule,
    "cylinder": Cylinder,
    "box": Box,
    "half-space": HalfSpace,
    "mesh": Mesh,
    "points": Points,
}

HELD = ("link", "allowed")
"""What an attached object has beside the fields of an obstacle."""


class Held(Section):
    link: str | None = None
    allowed: list[str] = []


# Sections ----------------------------------------------------------------------------------------------------------


class WorkspaceFields(Section):
    center: Vector
    radius: Positive


class OptionFields(Section):
    at_most_one = (("max_joint_step", "max_joint_step_deg"),)
    clearance: NotNegative | None = None
    self_clearance: NotNegative | None = None
    path_step: Positive | None = None
    max_joint_step: Positive | None = None
    max_joint_step_deg: Positive | None = None
    method: Literal["auto", "field", "tree", "reactive", "reactive-or-tree"] | None = None
    seed: Annotated[int, Field(ge=0)] | None = None
    time_limit: Positive | None = None
    improvement_time: NotNegative | None = None
    goal_tolerance: Positive | None = None
    angle_tolerance: Positive | None = None
    velocity_scale: Fraction | None = None
    acceleration_scale: Fraction | None = None
    time_step: Positive | None = None
    timing: Literal["smooth", "time-optimal"] | None = None
    jerk: Positive | None = None


class FieldFields(Section):
    rule: Literal["planar-log", "planar", "equilibrium", "safe", "monotone", "printed"] | None = None
    boundary: Positive | None = None
    blending: Literal["W1", "W2", "nearest", "simplex", "smooth", "sum", "printed", "printed-potential"] | None = None
    exponents: Numbers | None = None
    sensor_range: Positive | None = None


class ControlFields(Section):
    period: Positive | None = None
    law: Literal["implicit-unit-vector", "explicit", "boundary-layer", "super-twisting"] | None = None
    gain: Positive | None = None
    disturbance: NotNegative | None = None
    slow_down: bool | None = None
    grow_radius: bool | None = None
