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

    def finished(self) -> None:
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


class Crew:
    """Up to `workers` processes, kept from one `run` to the next; `close` ends them."""

    def __init__(self, workers: int, timeout: float) -> None:
        self.workers, self.timeout = workers, timeout
        self._events = queue.Queue[tuple[Worker, Row | None]]()
        self._alive: list[Worker] = []
        self._seconds: deque[float] = deque(maxlen=50)

    def run(self, tasks: Sequence[Task]) -> Iterator[Row]:
        """The rows of all tasks, as they come. A task that ends its process or takes over `timeout` seconds gets a row that
        says so. The first task of a crew runs alone: it leaves compiled code on the disk for the others.
        """
        waiting = deque(tasks)
        while waiting or any(worker.tasks for worker in self._alive):
            self._hire(waiting)
            try:
                worker, row = self._events.get(timeout=0.1)
            except queue.Empty:
                worker = row = None
            if worker in self._alive and row is not None:
                worker.finished()
                self._seconds.append(row["seconds"])
                yield row
            elif worker in self._alive:
                yield from self._bury(worker, waiting, "crashed", f"its process ended: {worker.last_words()}")
            for late in [w for w in self._alive if w.tasks and time.monotonic() - w.since > self.timeout]:
                late.kill()
                yield from self._bury(late, waiting, "timed out", f"still at it after {self.timeout:g} s")

    def close(self) -> None:
        """Ends every process, whatever it is at."""
        for worker in self._alive:
            worker.kill()
        self._alive.clear()

    def _hire(self, waiting: deque[Task]) -> None:
        """Gives every idle worker a chunk, and makes more workers while there is work for them."""
        most = self.workers if self._seconds else 1
        for worker in self._alive[:most]:
            if waiting and not worker.tasks:
                worker.give(take(waiting, chunk_size(self._seconds, len(waiting), self.workers)))
        while waiting and len(self._alive) < most:
            self._alive.append(Worker(self._events))
            self._alive[-1].give(take(waiting, 1))

    def _bury(self, worker: Worker, waiting: deque[Task], status: str, reason: str) -> Iterator[Row]:
        """The row of the task that a worker ended at; the rest of its chunk goes back to the front."""
        worker.kill()
        self._alive.remove(worker)
        if worker.tasks:
            poison = worker.tasks.popleft()
            waiting.extendleft(reversed(worker.tasks))
            yield lost(poison, status, reason, time.monotonic() - worker.since)


def take(waiting: deque[Task], count: int) -> list[Task]:
    """The next tasks."""
    return [waiting.popleft() for _ in range(min(count, len(waiting)))]


def chunk_size(seconds: Sequence[float], left: int, workers: int) -> int:
    """As many tasks as make a second of work, but no more than leave something for everybody."""
    typical = statistics.median(seconds) if seconds else CHUNK_SECONDS
    fair = -(-left // (2 * workers))
    return max(1, min(int(CHUNK_SECONDS / max(typical, 1e-4)), LARGEST_CHUNK, fair))


def lost(task: Task, status: str, reason: str, seconds: float | None = None) -> Row:
    """The row of a task that never answered."""
    row = {"key": task["key"], "problem": task["name"], "scene": task["scene"], "seed": task["seed"]}
    return row | {"status": status, "reason": reason, "seconds": seconds}
