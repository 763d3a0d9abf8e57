"""A cover of a mesh by balls or capsules: few of them, all of the mesh inside, and a bound of how far they stand out."""

from __future__ import annotations

from ._bodies import Body
from ._hold import bodies_about
from ._search import find_axes
from ._slack import slack_of
from ._solid import Solid

ROOM = 0.84
"""Share of the tolerance that the search is given: between its points, and by the grid of its depths, some is lost."""


def cover_solid(
    solid: Solid, budget: int, tolerance: float, *, capsules: bool, seed: int = 0
) -> tuple[list[Body], float]:
    """At most `budget` bodies that hold the solid, no more than a slack of `tolerance` (m) needs, and their slack.

    A ball of radius r about a point at depth d stands out of the solid by at most r - d, and so does a capsule all of whose
    axis lies at least so deep. So an axis and a slack fix a body, and axes are all that is searched for. Our derivation.
    """
    axes, depth, slack = find_axes(solid, budget, max(ROOM * tolerance, 1e-6), capsules, seed)
    bodies = bodies_about(solid, axes, depth, slack)
    return bodies, slack_of(bodies, solid)
