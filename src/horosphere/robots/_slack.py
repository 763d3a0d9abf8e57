"""How far a cover stands out of the solid that it covers: an upper bound."""

from __future__ import annotations

import numpy as np

from ._bodies import Body, Floats, distance_to_axis
from ._solid import Solid

LATTICE = 3_000


def slack_of(bodies: list[Body], solid: Solid) -> float:
    """No point of the capsules is further (m) from the solid than this."""
    return max((_slack(body, solid) for body in bodies), default=0.0)


def _slack(body: Body, solid: Solid) -> float:
    """The lesser of two bounds.

    Along the axis: a ball of radius r about a point at depth d stands out by at most r - d; between samples the depth changes
    by no more than the distance. On a lattice through the capsule: the distance of its points, plus half its diagonal.
    """
    length = float(np.linalg.norm(body.b - body.a))
    steps = int(np.clip(np.ceil(length / (0.25 * solid.cell)), 1, 400))
    along = body.a + np.linspace(0.0, 1.0, steps + 1)[:, None] * (body.b - body.a)
    depth = solid.depth(along)
    bound = float(np.max(body.radius - depth)) + 0.5 * length / steps
    if depth.min() >= 0.0:
        return bound
    return min(bound, _by_lattice(body, solid))


def _by_lattice(body: Body, solid: Solid) -> float:
    low, high = np.minimum(body.a, body.b) - body.radius, np.maximum(body.a, body.b) + body.radius
    step = float(np.prod(np.maximum(high - low, 1e-9)) / LATTICE) ** (1.0 / 3.0)
    counts = np.ceil((high - low) / step).astype(int) + 1
    axes = [np.linspace(low[k], high[k], counts[k]) for k in range(3)]
    x: Floats = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    reach = 0.5 * float(np.linalg.norm([axis[1] - axis[0] for axis in axes]))
    x = x[distance_to_axis(x, body) <= body.radius + reach]
    return float(np.max(np.maximum(-solid.depth(x), 0.0))) + reach
