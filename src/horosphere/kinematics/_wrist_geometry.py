"""Two arms with a spherical wrist, written once as conformal geometry: the 7-DOF S-R-S arm and the six-axis arm.

Our derivation, after the steps of [Humanoid] section V: planes and lines of the posture, angles by the ratio formula.
"""

from __future__ import annotations

from typing import Any

from ..kernels import E1, E2, E3, EI, MOTOR, MV, apply_motor, kernel, scalars, sincos, sqrt, where_lt
from ..kernels import maximum as _maximum
from ._ratio import (
    cross,
    dot,
    dual,
    euclid,
    half_turn,
    line,
    negated,
    norm,
    pair_points,
    plane,
    point,
    ratio,
    rotation,
    select,
    sphere,
    undual,
    vector,
)  # fmt: skip

_NO_PLANE = 1e-13  # a plane whose Euclidean norm is below this has no direction (lengths of order 1)
_NO_REFERENCE = 1e-9  # below this the reference direction is parallel to the line from shoulder to wrist
SRS_COLUMNS = 65  # angles 56, reach 1, gap 1, flags 4 (reference, theta2, theta4, theta6 free), elbow 3
SIX_COLUMNS = 57  # angles 48, reach 2, gap 2, on axis 1, straight wrist 4


def _carry(motor: MV, x: MV) -> MV:
    """The Euclidean point to which a motor carries a Euclidean point."""
    return vector(euclid(apply_motor(motor, point(x))))


def _turn(motor: MV, x: MV) -> MV:
    """The direction to which a motor turns a Euclidean direction."""
    return vector(euclid(apply_motor(motor, x)))


def _unit_plane(normal: MV, scale, spare: MV) -> tuple[MV, Any]:
    """The unit normal, or `spare` where it has no length; and 1 where that happened."""
    length = norm(normal) * (1.0 / scale)
    free = where_lt(length, _NO_PLANE, 1.0, 0.0)
    return select(length, _NO_PLANE, spare, normal * (1.0 / (where_lt(length, _NO_PLANE, 1.0, length) * scale))), free


def _swing(normal: MV, axis: MV, angle) -> MV:
    """A unit normal turned by `angle` = (sine, cosine) about a unit axis perpendicular to it."""
    return normal * angle[1] + cross(axis, normal) * angle[0]


def _either(free, kept, turned):
    """`turned`, but `kept` where the angle was free."""
    return where_lt(0.5, free, kept, turned)


@kernel(SRS_COLUMNS, m=MOTOR, psi=scalars(1), seed=scalars(7), arm=scalars(4))
def srs_branches(m, psi, seed, arm):
    """The 8 branches (theta2 < 0, theta4 < 0, theta6 < 0) of the S-R-S arm at the elbow angle psi.

    m: pose of the tip frame (origin F, axes of the base at home); arm: dbs, dse, dew, dwf. The elbow lies on the
    circle of the spheres about S and W; psi = 0 on the side of +z of the plane through S, W and z (of +x where S-W is
    parallel to z). Returns angles; reach (squared elbow radius over (dse + dew)^2); gap (metres missing); where psi =
    0 was defined by x and where theta1, theta3, theta5 were free (1 or 0); the elbow point.
    """
    dbs, dse, dew, dwf = arm
    shoulder = E3 * dbs
    wrist, flange = _carry(m, -E3 * dwf), _carry(m, MV({}))
    kept = [sincos(angle) for angle in seed]

    # The elbow circle z = s1 ^ s2, its reference point and the rotor about its axis.
    s1, s2 = sphere(point(shoulder), dse), sphere(point(wrist), dew)
    span = wrist - shoulder
    distance = norm(span)
    circle = s1 ^ s2
    upright = norm(cross(span, E3))
    reference = select(upright, _NO_REFERENCE * (dse + dew), E1, E3)
    cut = undual(point(shoulder) ^ point(wrist) ^ reference ^ EI)
    a, b, b2, v2 = pair_points(dual(circle ^ cut))
    first = dot(a - b, reference)
    start = select(0.0, first, a, b)
    safe = where_lt(_NO_PLANE, distance, distance, 1.0)
    axis = line(point(shoulder), select(_NO_PLANE, distance, span * (1.0 / safe), E3))
    half = sincos(psi[0] * 0.5)
    elbow = _carry(rotation(axis, *half), start)
    reach = b2 / (where_lt(0.0, v2, v2, 1.0) * ((dse + dew) * (dse + dew)))
    reach = where_lt(_NO_PLANE, distance, reach, -1.0)
    gap = _maximum(distance - (dse + dew), _maximum(dse - dew, dew - dse) - distance)

    # Unit directions of the links, and the planes through them that the joint axes 2, 4, 6 are normal to.
    upper, fore, hand = (elbow - shoulder) * (1.0 / dse), (wrist - elbow) * (1.0 / dew), (flange - wrist) * (1.0 / dwf)
    base, free1 = _unit_plane(cross(E3, upper), 1.0, _swing(E2, E3, kept[0]))
    elbow_plane, free3 = _unit_plane(cross(fore, upper), 1.0, _swing(base, upper, kept[2]))
    wrist_plane, free5 = _unit_plane(cross(fore, hand), 1.0, _swing(elbow_plane, fore, kept[4]))
    along = [line(point(p), d) for p, d in ((shoulder, E3), (shoulder, upper), (elbow, fore), (wrist, hand))]
    theta1 = ratio(base, E2, along[0])
    theta2 = ratio(along[1], along[0], line(point(shoulder), base))
    theta3 = ratio(plane(elbow_plane, point(shoulder)), plane(base, point(shoulder)), along[1])
    theta4 = ratio(line(point(elbow), fore), line(point(elbow), upper), line(point(elbow), -elbow_plane))
    theta5 = ratio(plane(wrist_plane, point(wrist)), plane(elbow_plane, point(wrist)), along[2])
    theta6 = ratio(line(point(wrist), hand), line(point(wrist), fore), line(point(wrist), wrist_plane))
    theta7 = ratio(plane(_turn(m, E2), point(flange)), plane(wrist_plane, point(flange)), along[3])

    # The other branches turn the normal of one plane: its own angle changes sign, its neighbours turn by pi. Where the
    # plane was free there is nothing to turn.
    angles = []
    for shoulder_turned in (False, True):
        first1, third1 = theta1, theta3
        if shoulder_turned:
            first1, third1 = _either(free1, theta1, half_turn(theta1)), _either(free1, theta3, half_turn(theta3))
        for elbow_turned in (False, True):
            third, fifth1 = third1, theta5
            if elbow_turned:
                third, fifth1 = _either(free3, third1, half_turn(third1)), _either(free3, theta5, half_turn(theta5))
            for wrist_turned in (False, True):
                fifth, seventh = fifth1, theta7
                if wrist_turned:
                    fifth, seventh = (
                        _either(free5, fifth1, half_turn(fifth1)),
                        _either(free5, theta7, half_turn(theta7)),
                    )
                angles += [first1, _either(free1, theta2, negated(theta2)) if shoulder_turned else theta2]
                angles += [third, _either(free3, theta4, negated(theta4)) if elbow_turned else theta4]
                angles += [fifth, _either(free5, theta6, negated(theta6)) if wrist_turned else theta6, seventh]
    by_x = where_lt(upright, _NO_REFERENCE * (dse + dew), 1.0, 0.0)
    return [*angles, reach, gap, by_x, free1, free3, free5, *euclid(elbow)]


@kernel(SIX_COLUMNS, m=MOTOR, seed=scalars(6), arm=scalars(6))
def six_axis_branches(m, seed, arm):
    """The 8 branches (back, elbow, flip) of the six-axis arm with spherical wrist; arm: a1, d1, a2, a3, d4, d6.

    m: pose of the tip frame (origin F, axes of the base at home). Returns angles; reach (squared half distance of the
    elbow pair over (a2 + |E W|)^2, front and back); gap (metres missing, front and back); 1 where the wrist is over
    axis 1 (theta1 kept); for (back, elbow) 1 where axes 4 and 6 are parallel (theta4 kept).
    """
    a1, d1, a2, a3, d4, d6 = arm
    wrist = _carry(m, -E1 * d6)
    hand = _turn(m, E1)
    forearm = sqrt(a3 * a3 + d4 * d4)
    kept = [sincos(angle) for angle in seed]
    l_z = line(point(MV({})), E3)
    pi_1, on_axis = _unit_plane(cross(E3, wrist), 1.0, _swing(E2, E3, kept[0]))
    front = ratio(pi_1, E2, l_z)

    angles, reaches, gaps, straight = [], [], [], []
    for normal, theta1 in ((pi_1, front), (-pi_1, half_turn(front))):
        shoulder = E3 * d1 + cross(normal, E3) * a1
        first, second, b2, v2 = pair_points(dual(sphere(point(shoulder), a2) ^ sphere(point(wrist), forearm) ^ normal))
        distance = norm(wrist - shoulder)
        span2 = where_lt(0.0, v2, v2, 1.0) * ((a2 + forearm) * (a2 + forearm))
        reaches.append(where_lt(distance, _NO_PLANE, -1.0, b2 / span2))
        gaps.append(_maximum(distance - (a2 + forearm), _maximum(a2 - forearm, forearm - a2) - distance))
        axis2 = line(point(shoulder), normal)
        for elbow in (first, second):
            upper, to_wrist = (elbow - shoulder) * (1.0 / a2), (wrist - elbow) * (1.0 / forearm)
            theta2 = ratio(line(point(shoulder), upper), line(point(shoulder), E3), axis2)
            # Axis 4 lies at the fixed angle atan2(a3, d4) from the line elbow-wrist.
            axis4 = (to_wrist * d4 + cross(normal, to_wrist) * a3) * (1.0 / forearm)
            theta3 = ratio(
                line(point(elbow), axis4), line(point(elbow), cross(normal, upper)), line(point(elbow), normal)
            )
            pi_w, free = _unit_plane(cross(axis4, hand), 1.0, _swing(normal, axis4, kept[3]))
            theta4 = ratio(plane(pi_w, point(wrist)), plane(normal, point(wrist)), line(point(wrist), axis4))
            theta5 = ratio(line(point(wrist), hand), line(point(wrist), axis4), line(point(wrist), pi_w))
            theta6 = ratio(_turn(m, E2), pi_w, line(point(wrist), hand))
            angles += [theta1, theta2, theta3, theta4, theta5, theta6]
            angles += [theta1, theta2, theta3, _either(free, theta4, half_turn(theta4))]
            angles += [_either(free, theta5, negated(theta5)), _either(free, theta6, half_turn(theta6))]
            straight.append(free)
    return [*angles, *reaches, *gaps, on_axis, *straight]
