"""How far configurations of an arm are from touching more than the scene allows, and what they touch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..distance import Contact, signed, table
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


@dataclass(frozen=True, slots=True)
class Touch:
    """What is `short` metres nearer to what than the scene allows; the other body is an obstacle or a link."""

    contact: Contact
    short: float
    is_obstacle: bool
    asked: float

    def __str__(self) -> str:
        link, other, distance = self.contact.link, self.contact.other, self.contact.distance
        if distance < 0.0:
            return f"link {link!r} reaches {-1e3 * distance:.3g} mm into {other!r}"
        return f"link {link!r} is {1e3 * distance:.3g} mm from {other!r}, {1e3 * self.asked:g} mm are asked"


def touch(scene: Scene, q: Floats) -> Touch:
    """What comes too close to what in the configuration, of q (m, n), with the largest margin."""
    best = q[int(np.argmax(margin(scene, q)))]
    links, options = set(arm(scene).link_names), scene.options
    touches = []
    for contact in table(arm(scene), best, scene.obstacles, static=False).contacts():
        asked = options.self_clearance if contact.other in links else options.clearance
        touches.append(Touch(contact, asked - contact.distance, contact.other not in links, asked))
    return max(touches, key=lambda t: t.short)
