"""Robot motion in conformal geometric algebra: geometry, kinematics, obstacle avoidance, certified plans.

    import horosphere as hs

Names are imported when they are first used (PEP 562), so that the import itself costs next to nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import (
        algebra as algebra,
    )
    from . import (
        certify as certify,
    )
    from . import (
        control as control,
    )
    from . import (
        distance as distance,
    )
    from . import (
        entities as entities,
    )
    from . import (
        errors as errors,
    )
    from . import (
        fields as fields,
    )
    from . import (
        io as io,
    )
    from . import (
        kernels as kernels,
    )
    from . import (
        kinematics as kinematics,
    )
    from . import (
        maps as maps,
    )
    from . import (
        planning as planning,
    )
    from . import (
        robots as robots,
    )
    from . import (
        scenes as scenes,
    )
    from . import (
        shapes as shapes,
    )
    from . import (
        snake as snake,
    )
    from . import (
        sweeps as sweeps,
    )
    from . import (
        versors as versors,
    )
    from .algebra import Multivector as Multivector
    from .entities import Circle as Circle
    from .entities import Line as Line
    from .entities import Plane as Plane
    from .entities import Point as Point
    from .entities import PointPair as PointPair
    from .entities import Sphere as Sphere
    from .errors import HorosphereError as HorosphereError
    from .errors import InputError as InputError
    from .scenes import Scene as Scene
    from .versors import Motor as Motor
    from .versors import Reflector as Reflector
    from .versors import Rotor as Rotor
    from .versors import Translator as Translator

__version__ = "0.1.0"

_HOME = {
    "Multivector": "algebra",
    **dict.fromkeys(("Point", "PointPair", "Line", "Circle", "Plane", "Sphere"), "entities"),
    **dict.fromkeys(("Reflector", "Translator", "Rotor", "Motor"), "versors"),
    "Scene": "scenes",
    **dict.fromkeys(("HorosphereError", "InputError"), "errors"),
}
_MODULES = (
    "algebra", "certify", "control", "distance", "entities", "errors", "fields", "io", "kernels", "kinematics",
    "maps", "planning", "robots", "scenes", "shapes", "snake", "sweeps", "versors",
)  # fmt: skip


def __getattr__(name: str) -> Any:
    if name in _HOME:
        value = getattr(import_module(f".{_HOME[name]}", __name__), name)
    elif name in _MODULES:
        value = import_module(f".{name}", __name__)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*(name for name in globals() if name.startswith("__")), *_HOME, *_MODULES})
