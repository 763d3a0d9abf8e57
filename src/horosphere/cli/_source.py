"""What a command is called with: a robot file and how it is read; a scene of ours or a MoveIt problem with what belongs to it."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal

from cyclopts import Group, Parameter

from ._values import Whole


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Loading:
    """What is made of a robot file.

    Parameters
    ----------
    base
        First link of the chain (URDF), the root by default.
    tip
        Last link of the chain (URDF); needed if the tree has several leaves.
    capsules
        A capsule file with the collision bodies, for a robot whose meshes are missing.
    link_radius
        Metres; capsules of this radius along the links that have no collision body.
    srdf
        A MoveIt SRDF: pairs of links that it disables are not checked against each other.
    group
        The group of the SRDF whose chain is taken.
    collision
        What meshes are covered by.
    budget
        At most so many bodies round the meshes of a link: 40 capsules or 48 spheres by default.
    tolerance
        Metres; no more bodies than keep them from standing out of the meshes further than this: 0.015, or a fifth of a small link.
    geometry
        What is covered: `auto` is the collision geometry, and the visual one where that is missing.
    """

    base: str | None = None
    tip: str | None = None
    capsules: Path | None = None
    link_radius: float | None = None
    srdf: Path | None = None
    group: str | None = None
    collision: Literal["capsules", "spheres"] = "capsules"
    budget: Whole | None = None
    tolerance: float | None = None
    geometry: Literal["auto", "collision", "visual"] = "auto"

    @property
    def given(self) -> dict[str, Any]:
        """Those that differ from what is usual, for `robots.load`."""
        return {item.name: value for item in fields(self) if (value := getattr(self, item.name)) != item.default}


USUAL = Loading()


@Parameter(name="*", group=Group("MoveIt scenes", sort_key=2))
@dataclass(frozen=True, kw_only=True)
class MoveIt:
    """What a MoveIt scene needs beside its file.

    Parameters
    ----------
    robot
        The robot: a URDF, a robot file (YAML) or a built-in name.
    tip
        The tip link of the URDF; by default the end of the chain that the goal moves.
    srdf
        The SRDF of the URDF: its groups, and the pairs of links that are not checked.
    request
        The motion-plan request; by default request0001.yaml beside scene0001.yaml, and so on.
    """

    robot: str | None = None
    tip: str | None = None
    srdf: Path | None = None
    request: Path | None = None

    @property
    def given(self) -> dict[str, Any]:
        """What was said on the command line."""
        return {item.name: value for item in fields(self) if (value := getattr(self, item.name)) is not None}

    def load(self, scene: str) -> Any:
        """The scene. Raises InputError."""
        from ..scenes import Scene

        return Scene.load(scene, **self.given)


NOTHING = MoveIt()
