"""Workers on this machine: each a process that is fed chunks, watched, and replaced when it crashes or hangs."""

from __future__ import annotations

import json
import queue
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import Any

Task = dict[str, Any]
Row = dict[str, Any]
CHUNK_SECONDS = 1.0
"""Work handed over at a time: what is said between processes must not count."""
LARGEST_CHUNK = 100


class Worker:
    """One process and what it was given; its rows and its end (None) come as events (worker, row)."""

    def __init__(self, events: queue.Queue[tuple[Worker, Row | None]]) -> None:
        self._errors = tempfile.TemporaryFile()  # it lives as long as the process  # noqa: SIM115
        self._process = subprocess.Popen(
            [sys.executable, "-m", "horosphere.sweeps._worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            text=True,
            encoding="utf-8",
            start_new_session=True,  # Ctrl-C is for us: we stop it
        )
        self.tasks: deque[Task] = deque()
        self.since = time.monotonic()
        self._events = events
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            try:
                self._events.put((self, json.loads(line)))
            except ValueError:  # the last words of a dying process
                break
        self._events.put((self, None))

    def give(self, chunk: Sequence[Task]) -> None:
        """More to do."""
        assert self._process.stdin is not None
        if not self.tasks:
            self.since = time.monotonic()
        self.tasks.extend(chunk)
        with suppress(OSError, ValueError):  # it died meanwhile: its end comes as an event
            for task in chunk:
                self._process.stdin.write(json.dumps(task) + "\n")
            self._process.stdin.flush()

    def finished(self, row: Row) -> None:
        """It has done the first of its tasks."""
        self.tasks.popleft()
        self.since = time.monotonic()

    def kill(self) -> None:
        """Ends the process, whatever it is at."""
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                with suppress(OSError):
                    pipe.close()

    def last_words(self) -> str:
        """Why the process ended: its signal or exit code, and the first line of what it wrote to standard error."""
        code = self._process.wait()
        how = f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
        self._errors.seek(0)
        lines = self._errors.read().decode(errors="replace").strip().splitlines()
        told = next((line for line in lines if line.startswith("Fatal Python error")), lines[-1] if lines else "")
        return f"{how}: {told}" if told else how


def run_local(tasks: Sequence[Task], workers: int, timeout: float) -> Iterator[Row]:
    """The rows of all tasks, as they come. A task that ends its process or takes over `timeout` seconds gets a row that says so.

    The first task runs alone: it leaves compiled code on the disk for the others.
    """
    waiting, events = deque(tasks), queue.Queue[tuple[Worker, Row | None]]()
    alive: list[Worker] = []
    seconds: deque[float] = deque(maxlen=50)
    try:
        while waiting or any(worker.tasks for worker in alive):
            _hire(alive, waiting, events, workers if seconds else 1, seconds)
            try:
                worker, row = events.get(timeout=0.1)
            except queue.Empty:
                worker = row = None
            if worker in alive and row is not None:
                worker.finished(row)
                seconds.append(row["seconds"])
                yield row
            elif worker in alive:
                yield from _buried(worker, alive, waiting, "crashed", f"its process ended: {worker.last_words()}")
            for late in [w for w in alive if w.tasks and time.monotonic() - w.since > timeout]:
                late.kill()
                yield from _buried(late, alive, waiting, "timed out", f"still at it after {timeout:g} s")
    finally:
        for worker in alive:
            worker.kill()


def _hire(alive: list[Worker], waiting: deque[Task], events: Any, workers: int, seconds: deque[float]) -> None:
    """Gives every idle worker a chunk, and makes more workers while there is work for them."""
    while waiting and len(alive) < workers:
        alive.append(Worker(events))
        alive[-1].give(take(waiting, 1))
    for worker in alive[: workers if seconds else 1]:
        if waiting and not worker.tasks:
            worker.give(take(waiting, chunk_size(seconds, len(waiting), workers)))


def take(waiting: deque[Task], count: int) -> list[Task]:
    """The next tasks."""
    return [waiting.popleft() for _ in range(min(count, len(waiting)))]


def chunk_size(seconds: Sequence[float], left: int, workers: int) -> int:
    """As many tasks as make a second of work, but no more than leave something for everybody."""
    typical = statistics.median(seconds) if seconds else CHUNK_SECONDS
    fair = -(-left // (2 * workers))
    return max(1, min(int(CHUNK_SECONDS / max(typical, 1e-4)), LARGEST_CHUNK, fair))


def _buried(worker: Worker, alive: list[Worker], waiting: deque[Task], status: str, reason: str) -> Iterator[Row]:
    """The row of the task that a worker ended at; the rest of its chunk goes back to the front."""
    worker.kill()
    alive.remove(worker)
    if not worker.tasks:
        return
    poison = worker.tasks.popleft()
    waiting.extendleft(reversed(worker.tasks))
    yield lost(poison, status, reason, time.monotonic() - worker.since)


def lost(task: Task, status: str, reason: str, seconds: float | None = None) -> Row:
    """The row of a task that never answered."""
    row = {"key": task["key"], "problem": task["name"], "scene": task["scene"], "seed": task["seed"]}
    return row | {"status": status, "reason": reason, "seconds": seconds}
