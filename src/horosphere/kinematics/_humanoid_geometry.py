"""The inverse kinematics of the 5-DOF humanoid arm, written once as conformal geometry: all 8 branches of one target.

[Humanoid] section V with the corrections of docs/errata.md. The traced kernels run on single targets and on lanes.
"""

from __future__ import annotations

from ..kernels import E0, E1, E2, E3, EI, absolute, apply_motor, kernel, maximum, scalars, sincos, where_lt
from ._ratio import (
    cross,
    direction,
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
_NO_RADIAL = 1e-9  # below this the radial direction has no usable projection on the target plane
BRANCH_COLUMNS = 57  # angles 40, reach 2, gap 2, on-axis 1, straight 4, miss 4, side 4


@kernel(4, pt=scalars(3), n=scalars(3), phi=scalars(1), d3=scalars(1))
def gripper_circle(pt, n, phi, d3):
    """Step 1: the wrist p2 at the angle phi of the circle z_t, and 1 where phi = 0 had to be defined by a spare
    direction.

    z_t = s_t ^ pi_t; the plane through its axis j_z and the radial direction d cuts it in two points. p2 at phi = 0
    is the one from which the gripper points outwards; the rotor about the axis carries it to phi ([Humanoid] eq. 30,
    corrected).
    """
    pt, n = vector(pt), vector(n)
    target = point(pt)
    z_t = sphere(target, d3[0]) ^ plane(n, target)
    radial = pt - E2 * dot(pt, E2)  # from the torso axis l_y to the target
    projected = norm(radial - n * dot(radial, n))
    outward = select(projected, _NO_RADIAL, select(absolute(dot(n, E2)), 0.9, E2, E1), radial)
    cut = undual((z_t ^ EI) ^ outward)
    a, b, _, _ = pair_points(dual(cut ^ z_t))
    p2 = select(0.0, dot(pt - a, outward), a, b)
    sine, cosine = sincos(phi[0] * 0.5)
    p2 = apply_motor(rotation(line(target, n), sine, cosine), point(p2))
    return [*euclid(p2), where_lt(projected, _NO_RADIAL, 1.0, 0.0)]


@kernel(BRANCH_COLUMNS, p2=scalars(3), pt=scalars(3), seed=scalars(5), hinge=scalars(3), arm=scalars(5))
def humanoid_branches(p2, pt, seed, hinge, arm):
    """Steps 2-5 for the 8 branches (back, elbow, flip) of a wrist p2 and a gripper point pt.

    seed: angles kept where one is free. hinge: the wanted unit normal of the wrist plane (minus the axis of J5), or 0
    for the plane of p1, p2, pt. arm: a, h, d1, d2, d3.
    Returns the angles; reach (squared half distance of the elbow pair over (d1 + d2)^2, front and back); gap (metres
    missing between shoulder and wrist, front and back); 1 where p2 is on the torso axis; then for (back, elbow): 1
    where the wrist is straight, the cosine between forearm and hinge (0 when the wanted hinge is possible), the sign
    of theta5 with that hinge.
    """
    a, h, d1, d2, d3 = arm
    p2, pt, hinge = vector(p2), vector(pt), vector(hinge)
    l_y = line(E0, E2)
    kept = [sincos(angle) for angle in seed]
    wanted = dot(hinge, hinge)

    # Step 2: the arm plane pi_1* = l_y* ^ p2. On the torso axis it is free: keep theta1.
    pi_1 = undual(dual(l_y) ^ point(p2))
    radius = norm(pi_1)
    normal = vector(euclid(pi_1)) * (1.0 / where_lt(radius, _NO_PLANE, 1.0, radius))
    normal = select(radius, _NO_PLANE, vector([kept[0][0], 0.0, kept[0][1]]), normal)
    front = ratio(normal, E3, l_y)

    angles, reaches, gaps, straight, misses, sides = [], [], [], [], [], []
    for pi_b, theta1 in ((normal, front), (-normal, half_turn(front))):
        # Step 3: the shoulder, the point of the circle z_0 on the front side of pi_b.
        p0 = E2 * h + cross(E2, pi_b) * a
        # Step 2 again: the elbows; of the pair s1 ^ s2 ^ pi_b the second point has theta3 >= 0.
        down, up, b2, v2 = pair_points(dual(sphere(point(p0), d1) ^ sphere(point(p2), d2) ^ pi_b))
        distance = norm(p2 - p0)
        together = where_lt(distance, 1e-12 * (d1 + d2), 1.0, 0.0)
        equal = where_lt(absolute(d1 - d2), 1e-9, 1.0, 0.0)
        span2 = where_lt(0.0, v2, v2, 1.0) * ((d1 + d2) * (d1 + d2))
        reaches.append(where_lt(0.5, together, equal - 1.0, b2 / span2))
        gaps.append(maximum(distance - (d1 + d2), absolute(d1 - d2) - distance))
        # Wrist on the shoulder: theta3 = pi and theta2 is free: keep it.
        axis2 = -undual(point(p0) ^ pi_b ^ EI)
        folded = p0 + (E2 * kept[1][1] + cross(direction(axis2), E2) * kept[1][0]) * d1
        bend = None
        for p1 in (up, down):
            p1 = select(0.5, together * equal, folded, p1)
            along = (p2 - p1) * (1.0 / d2)
            # Step 4, the lines; Step 5, signed angles by the ratio formula.
            l1, l2, l3 = line(point(p0), p1 - p0), line(point(p1), p2 - p1), line(point(p2), pt - p2)
            theta2 = ratio(l1, line(point(p0), E2), axis2)
            theta3 = ratio(l2, l1, -undual(point(p1) ^ pi_b ^ EI)) if bend is None else negated(bend)
            bend = theta3
            # The wrist plane, oriented so that theta5 >= 0. Straight wrist: keep theta4.
            pi_w = -undual(point(p1) ^ point(p2) ^ point(pt) ^ EI)
            sine5 = norm(pi_w) * (1.0 / (d2 * d3))
            keep = pi_b * kept[3][1] + cross(along, pi_b) * kept[3][0]
            wrist = select(sine5, _NO_PLANE, keep, vector(euclid(pi_w)))
            wrist = select(0.5, wanted, hinge, wrist)
            wrist = wrist * (1.0 / norm(wrist))
            theta4 = ratio(wrist, pi_b, l2 * (1.0 / d2))
            theta5 = ratio(l3, l2, -undual(point(p2) ^ wrist ^ EI))
            turned = half_turn(theta4)
            angles += [theta1, theta2, theta3, where_lt(theta5, 0.0, turned, theta4), absolute(theta5)]
            angles += [theta1, theta2, theta3, where_lt(theta5, 0.0, theta4, turned), negated(absolute(theta5))]
            straight.append(where_lt(sine5, _NO_PLANE, 1.0, 0.0))
            misses.append(dot(along, hinge))
            sides.append(where_lt(theta5, 0.0, -1.0, 1.0))
    return [*angles, *reaches, *gaps, where_lt(radius, _NO_PLANE, 1.0, 0.0), *straight, *misses, *sides]
