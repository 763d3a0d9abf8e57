"""How far configurations of an arm are from touching more than the scene allows, and what they touch."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..distance import signed, table
from ..robots import Robot
from ..scenes import Scene

Floats = NDArray[np.float64]


def arm(scene: Scene) -> Robot:
    """The scene's robot, where it is an arm: the only kind that comes here."""
    assert isinstance(scene.robot, Robot)
    return scene.robot


def margin(scene: Scene, q: Floats) -> Floats:
    """Metres (m,) above the clearances the scene asks for, from obstacles and from the robot itself; negative: too close."""
    options = scene.options
    own = signed(arm(scene), q, (), self_collision=True) - options.self_clearance
    return np.minimum(signed(arm(scene), q, scene.obstacles, static=False) - options.clearance, own)


def collision_reason(scene: Scene, q: Floats) -> str:
    """What comes too close to what in the configuration, of q (m, n), with the largest margin."""
    best = q[int(np.argmax(margin(scene, q)))]
    asked = {True: scene.options.self_clearance, False: scene.options.clearance}
    links = set(arm(scene).link_names)
    near = [(c.distance - asked[c.other in links], c) for c in table(arm(scene), best, scene.obstacles, static=False).contacts()]
    _, contact = min(near, key=lambda pair: pair[0])
    where = f"link {contact.link!r}", f"{contact.other!r}"
    if contact.distance < 0.0:
        return f"{where[0]} reaches {-contact.distance:.3g} m into {where[1]}"
    wanted = asked[contact.other in links]
    return f"{where[0]} is {contact.distance:.3g} m from {where[1]}, {wanted:g} m are asked"
