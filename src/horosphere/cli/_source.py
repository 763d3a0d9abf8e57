"""The scene that a command is called with: a file of ours, a built-in name, or a MoveIt problem with what belongs to it."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from cyclopts import Group, Parameter


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
