"""A running Dask cluster: it gets chunks, and every Dask worker solves them in a process beside it, as this machine does."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Iterator, Sequence
from typing import Any

from ..errors import InputError
from ._pool import Crew, Row, Task, chunk_size, lost, take

TRIES = 3
"""Times that a task may go under with the machine it ran on before it counts as the reason."""


_own = threading.local()


def run_chunk(tasks: list[Task], timeout: float) -> list[Row]:
    """What runs on the cluster: a crash ends the process beside the Dask worker, never the Dask worker itself.

    The process stays for the next chunk, one a thread; it ends with the Dask worker.
    """
    crew = getattr(_own, "crew", None)
    if crew is None or crew.timeout != timeout:
        if crew is not None:
            crew.close()
        crew = _own.crew = Crew(1, timeout)
    return list(crew.run(tasks))


def run_cluster(tasks: Sequence[Task], address: str, timeout: float) -> Iterator[Row]:
    """The rows of all tasks, as they come, from the cluster whose scheduler listens at `address`.

    Scene files must be readable there under the same path. Chunks that went under with their machine are tried again task by
    task. Raises InputError without `distributed`, without an answer, or if the workers lack horosphere.
    """
    try:
        import distributed  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise InputError(
            "a cluster needs the extra `cluster`", place="scheduler", remedy="pip install 'horosphere[cluster]'"
        ) from None
    try:
        client = distributed.Client(address, timeout=10, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(f"no Dask scheduler answers at {address} ({error})", place="scheduler") from None
    with client, client.as_current():
        threads = sum(client.nthreads().values())
        if not threads:
            raise InputError(
                f"the cluster at {address} has no workers", place="scheduler", remedy="start `dask worker`"
            )
        yield from _run(client, distributed, deque(tasks), threads, timeout)


def _run(client: Any, distributed: Any, waiting: deque[Task], threads: int, timeout: float) -> Iterator[Row]:
    seconds: deque[float] = deque(maxlen=50)
    tries: dict[str, int] = {}
    flying: dict[Any, list[Task]] = {}
    done = distributed.as_completed()
    while waiting or flying:
        while waiting and len(flying) < 2 * threads:
            alone = waiting[0]["key"] in tries
            if alone and any(task["key"] in tries for chunk in flying.values() for task in chunk):
                break  # suspects fly one at a time
            chunk = take(waiting, 1 if alone else chunk_size(seconds, len(waiting), threads))
            future = client.submit(run_chunk, chunk, timeout, pure=False)
            flying[future] = chunk
            done.add(future)
        future = next(done)
        chunk = flying.pop(future)
        error = future.exception()
        if error is None:
            for row in future.result():
                seconds.append(row["seconds"] or 0.0)
                yield row
        elif isinstance(error, (ImportError, AttributeError)):
            raise InputError(f"its workers cannot run this: {error}", place="scheduler",
                             remedy="install the same horosphere there") from None  # fmt: skip
        else:  # the machine went under: the last in the row are the suspects
            for task in chunk:
                tries[task["key"]] = tries.get(task["key"], 0) + 1
                if tries[task["key"]] >= TRIES:
                    yield lost(task, "crashed", f"its machine was lost {TRIES} times: {type(error).__name__}")
                else:
                    waiting.append(task)
