"""From a scene to a certified motion: the field leads, closed forms choose the posture, the certificate decides."""

from typing import Any

from ._plan import Plan as Plan
from ._plan import plan as plan

_LATER = {  # what needs more than a scene is imported when it is asked for
    "harmonic_field": "_point",
    "connect": "_tree",
    "starter_scene": "_starter",
    "react": "_reactive",
    "bench_mbm": "_bench",
    "bench_random": "_bench",
    "Resampled": "_resample",
    "resample": "_resample",
    "time_optimal_path": "_time_optimal",
}


def __getattr__(name: str) -> Any:
    if name in _LATER:
        from importlib import import_module

        return getattr(import_module(f".{_LATER[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
