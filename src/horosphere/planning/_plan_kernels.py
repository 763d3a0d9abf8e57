"""What a call of the tree planner does, from the scene to a certified path, as one compiled function: the ladder of margins.

Its parts are called through their addresses in the packet: so each is compiled once, not again as a part of this.

Of the packet, beside what `_edge_kernels` and `_tree_kernels` tell:
  scene: the solids as rows and what packs them, see `sort_solids`
  task = (settings, rungs, progress)
    settings (6,)        see the numbers below; SLACK is written when the scene is packed
    rungs (k, 4)         one a row: margin beyond the clearance, beyond the one to the robot itself, most iterations, and
                         SAMPLED or CERTIFIED
    progress (14,)       see the numbers below; the last four are nanoseconds
"""

import numpy as np

from ..kernels import call_compiled, inner, jit
from ._edge_kernels import CERTIFIED
from ._packet_kernels import (
    CERTIFY,
    CHECK,
    CHUNK,
    FINISH,
    GROW,
    GROW_TREES,
    NOT_CERTIFIED,
    PACK,
    PACK_SCENE,
    PAUSED,
    RESUME,
    SIMPLIFY,
    TIME_OVER,
    TREES_FULL,
    called,
    now,
    opened,
    opened_task,
)
from ._world_kernels import sort_solids

CLEARANCE, SELF_CLEARANCE, PACK_MARGIN, CENTRE_SLACK, ROBOT_SIZE, SLACK = range(6)
SOLIDS, GOALS, RUNGS, RUNG, POINTS, SHORTEN, DONE, ITERATIONS, HALVES, DEADLINE = range(10)
PACKING, GROWING, SIMPLIFYING, CERTIFYING = range(10, 14)
"""Given: how many solids, goals and rungs, the rung to begin at, points of a path that is there, whether to shorten, and when to
end. Told: the rung, iterations on it (given to CHECK: the first motion) and on all, halves of its margin that are certified, times."""
ROUNDS, TRIES, LEAST_GAIN = 3, 3, 0.03
"""Of `simplify`."""
SLICE = 200_000_000
"""Nanoseconds after which Python is asked whether to go on (so that a signal gets through)."""
SIZE_SLACK = 16.0 * 2.0**-24


@inner
def lap(packet, progress, part, begin):
    """Adds the time since `begin` to a part; the time."""
    end = now(packet)
    progress[part] += end - begin
    return end


@called
def pack_scene(packet):
    """The solids sorted into `world`; what rounding may hide, with them, goes into the settings."""
    search, scene, task = opened_task(packet)
    settings, rungs, progress = task
    extent = sort_solids(progress[SOLIDS], settings[PACK_MARGIN], scene, opened(packet)[1])
    settings[SLACK] = settings[CENTRE_SLACK] + SIZE_SLACK * (extent + settings[ROBOT_SIZE])
    return np.int64(0)


@jit(_nrt=False)
def plan(packet, stage):
    """Points of a certified path, written to `path`, or why there is none: 0, TREES_FULL, START_BLOCKED .. PAUSED.

    From `stage` on: the scene is packed; on each rung trees grow, and what they find is shortened and certified: with half
    of the rung's margin, as most paths keep that between their points too, or with none. What ends a rung leads to the next.
    CHECK: the first motion of the path that is not certified with the margins of rung 0, or -1.
    """
    search, scene, task = opened_task(packet)
    state = search[8]
    settings, rungs, progress = task
    time = now(packet)
    pause = time + SLICE
    if stage == PACK:
        call_compiled(packet[PACK_SCENE], (packet,))
        time = lap(packet, progress, np.int64(PACKING), time)
    clearance, self_clearance, slack = settings[CLEARANCE], settings[SELF_CLEARANCE], settings[SLACK]
    if stage == CHECK:
        margin, self_margin = clearance + rungs[0, 0] + slack, self_clearance + rungs[0, 1] + 2.0 * slack
        return call_compiled(packet[CERTIFY], (packet, progress[DONE], progress[POINTS], margin, self_margin))
    outcome = np.int64(0)
    for rung in range(progress[RUNG], progress[RUNGS]):
        progress[RUNG] = rung
        extra, count = rungs[rung, 0], progress[POINTS]
        margin, self_margin = clearance + extra + slack, self_clearance + rungs[rung, 1] + 2.0 * slack
        if stage < FINISH:
            if stage != RESUME:
                state[0], progress[DONE] = -1, 0
            stage, how = np.int64(GROW), np.int64(rungs[rung, 3])
            while True:
                arguments = packet, progress[GOALS], np.int64(CHUNK), how, margin, self_margin
                count = call_compiled(packet[GROW_TREES], arguments)
                progress[DONE] += CHUNK
                time = lap(packet, progress, np.int64(GROWING), time)
                if count != 0 or progress[DONE] >= rungs[rung, 2] or time > progress[DEADLINE]:
                    break
                if time > pause:
                    return np.int64(PAUSED)
            progress[ITERATIONS] += max(state[0], 0)
            if count <= 0:
                outcome = count
                if count >= TREES_FULL and time > progress[DEADLINE]:
                    return np.int64(TIME_OVER)
                continue
        if progress[SHORTEN] and rungs[rung, 3] != CERTIFIED and count > 2:
            arguments = packet, count, np.int64(ROUNDS), np.int64(TRIES), LEAST_GAIN, margin, self_margin
            count = call_compiled(packet[SIMPLIFY], arguments)
            time = lap(packet, progress, np.int64(SIMPLIFYING), time)
        halves = np.int64(1 if extra > 0.0 else 0)
        while halves >= 0:
            part = 0.5 * halves * extra
            margin, self_margin = clearance + part + slack, self_clearance + part + 2.0 * slack
            if call_compiled(packet[CERTIFY], (packet, np.int64(0), count, margin, self_margin)) < 0:
                break
            halves -= 1
        time = lap(packet, progress, np.int64(CERTIFYING), time)
        if halves >= 0:
            progress[HALVES] = halves
            return count
        outcome = np.int64(NOT_CERTIFIED)
    return outcome
