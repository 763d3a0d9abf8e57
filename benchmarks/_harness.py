"""Timing several implementations side by side in one run: round robin, medians, ratios against ours."""

from __future__ import annotations

import gc
import platform
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from importlib import metadata
from pathlib import Path

Contender = Callable[[], object]


def heading(*packages: str) -> None:
    """Print what was measured, on what."""
    cpu = next((line.split(":")[1].strip() for line in _read("/proc/cpuinfo") if line.startswith("model name")), "?")
    root = Path(__file__).resolve().parent.parent
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=root, capture_output=True, text=True)
    versions = ", ".join(f"{name} {_version(name)}" for name in ("horosphere", "numpy", "numba", *packages))
    print(f"{versions}\ncommit {commit.stdout.strip() or '?'}, Python {platform.python_version()}, {cpu}")


def compare(
    title: str,
    contenders: dict[str, Contender | tuple[Contender, int] | None],
    items: int = 1,
    rounds: int = 9,
    seconds_a_round: float = 0.02,
) -> dict[str, float]:
    """Median seconds per item of each contender, printed with the ratio to the first one (ours).

    All run in turn, round by round, and a ratio is the median of the ratios of single rounds, so that a drift of the
    machine's speed meets all of them alike. None: not installed; (call, its own number of items): one that is looped.
    """
    calls, given = {}, {}
    for name, contender in contenders.items():
        function, size = contender if isinstance(contender, tuple) else (contender, items)
        if function is None:
            continue
        given[name] = function, size
        function()
        function()
        started = time.perf_counter()
        function()
        calls[name] = max(1, int(seconds_a_round / max(time.perf_counter() - started, 1e-8)))
    seconds: dict[str, list[float]] = {name: [] for name in calls}
    gc.disable()
    for _ in range(rounds):
        for name, count in calls.items():
            function, size = given[name]
            started = time.perf_counter()
            for _ in range(count):
                function()
            seconds[name].append((time.perf_counter() - started) / count / size)
    gc.enable()
    medians = {name: statistics.median(values) for name, values in seconds.items()}
    ours = next(iter(seconds.values()))
    print(f"\n{title}")
    for name in contenders:
        if name in medians:
            ratio = statistics.median(theirs / own for theirs, own in zip(seconds[name], ours, strict=True))
            low, high = min(seconds[name]), max(seconds[name])
            print(f"  {name:42s} {_time(medians[name]):>10s}  {ratio:9.2f}x   ({_time(low)} .. {_time(high)})")
        else:
            print(f"  {name:42s} not installed")
    sys.stdout.flush()
    return medians


def _time(seconds: float) -> str:
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"


def _read(path: str) -> list[str]:
    try:
        return Path(path).read_text().splitlines()
    except OSError:
        return []
