"""Forward kinematics on lanes, and how far a point can move: single precision, sixteen configurations at a time.

For the data see `_edge_kernels`.
"""

from ..kernels import (
    absolute,
    atom,
    floor,
    inner,
    kernel,
    lane_sqrt,
    load_columns,
    load_records,
    polynomial,
    round_even,
    scalars,
    store_columns,
    where_lt,
)
from ._packet_kernels import opened

LANES = (0,) * 16
WIDTH = len(LANES)

# pi/2 in three parts; the first two have few bits, so that multiples of them are exact
_HALF_PI = (1.5703125, 4.837512969970703125e-4, 7.54978995489188216e-8)
_SIN = (-1.6666654611e-1, 8.3321608736e-3, -1.9515295891e-4)
_COS = (4.166664568298827e-2, -1.388731625493765e-3, 2.443315711809948e-5)


def sincos_single(x):
    """(sin x, cos x) to 1.2e-7 for |x| < 1e4 in single precision."""
    k = round_even(x * 0.6366197723675814)
    r = x
    for part in _HALF_PI:
        r = atom(r - k * part)
    z = atom(r * r)
    sine = r + r * z * polynomial(z, _SIN)
    cosine = 1.0 - 0.5 * z + z * z * polynomial(z, _COS)
    quadrant = k - 4.0 * floor(k * 0.25)
    odd = quadrant - 2.0 * floor(quadrant * 0.5)
    s, c = where_lt(odd, 0.5, sine, cosine), where_lt(odd, 0.5, cosine, sine)
    return where_lt(quadrant, 1.5, s, -s), where_lt(absolute(quadrant - 1.5), 1.0, -c, c)


@kernel(12, parent=scalars(12), at=None, joint=scalars(16))
def next_frame(parent, at, joint):
    """Axes and origin of a frame from those of its parent: origin, then a turn about and a slide along the z axis."""
    X, Y, Z, p = parent[0:3], parent[3:6], parent[6:9], parent[9:12]
    x, y, z, origin = ([X[k] * c[0] + Y[k] * c[1] + Z[k] * c[2] for k in range(3)] for c in
                       (joint[0:3], joint[3:6], joint[6:9], joint[9:12]))  # fmt: skip
    s, c = sincos_single(at * joint[12] + joint[13])
    slide = at * joint[14] + joint[15]
    x, y = [atom(v) for v in x], [atom(v) for v in y]
    return [
        *(c * x[k] + s * y[k] for k in range(3)),
        *(c * y[k] - s * x[k] for k in range(3)),
        *z,
        *(p[k] + origin[k] + slide * z[k] for k in range(3)),
    ]


@kernel(3, frame=scalars(12), at=scalars(4))
def carried(frame, at):
    """A point fixed to a frame, in the base."""
    return [frame[9 + k] + frame[k] * at[0] + frame[3 + k] * at[1] + frame[6 + k] * at[2] for k in range(3)]


@kernel(1, p=scalars(3), axis=scalars(6))
def lever_square(p, axis):
    """Squared distance of a point to the axis (unit direction, point)."""
    d = [p[k] - axis[3 + k] for k in range(3)]
    t = d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2]
    w = [atom(d[k] - t * axis[k]) for k in range(3)]
    return [w[0] * w[0] + w[1] * w[1] + w[2] * w[2]]


next_frame_inline, carried_inline, lever_square_inline = next_frame.inline, carried.inline, lever_square.inline


@inner
def place_frames(q, v, t, joints, joint_data, frames):
    """Write the frames at q + t v, one t in each lane."""
    for f in range(1, joints.shape[0]):
        c = joints[f, 1]
        parent = load_columns(frames, 12 * WIDTH * joints[f, 0], 12, LANES)
        at = t * v[c] + q[c]
        store_columns(frames, 12 * WIDTH * f, next_frame_inline(*parent, at, *load_records(joint_data, f, 16, (0,))))


@inner
def motion_bound(frame, stop, x, y, z, half, v, packet):
    """No point (x, y, z) fixed to `frame` moves further than this, seen from frame `stop`, within `half` of the middle.

    Joint after joint from the point inwards: a turn by at most a moves it by at most a times its distance from the axis
    in the middle plus what the joints before have moved it (a distance from a line changes by no more than that).
    """
    model, world, scratch = opened(packet)
    joints, joint_data, frames = model[0], model[1], scratch[0]
    total = half * 0.0
    f = frame
    while f != stop:
        axis = load_columns(frames, (12 * f + 6) * WIDTH, 6, LANES)
        speed = abs(v[joints[f, 1]])
        lever = lane_sqrt(lever_square_inline(x, y, z, *axis)[0])
        total = (
            total + half * (speed * abs(joint_data[f, 12])) * (lever + total) + half * (speed * abs(joint_data[f, 14]))
        )
        f = joints[f, 0]
    return total * 1.00001
