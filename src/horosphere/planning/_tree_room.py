"""Working memory of the tree planner, kept from call to call, one a thread."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
CAPACITY = 1 << 16
"""Nodes of a tree."""
SAMPLES = 1 << 13


class Room:
    """Working memory of one thread for robots of n joints; its arrays are those of `_tree_kernels` and `_plan_kernels`."""

    def __init__(self, n: int) -> None:
        self.n = n
        self.nodes = np.zeros((2 * n, CAPACITY), np.float32)
        self.parents, self.radii = np.zeros((2, CAPACITY), np.int64), np.zeros((2, CAPACITY), np.float32)
        self.state = np.zeros(6, np.int64)
        self.path = np.zeros((4096, n), np.float32)
        lanes = np.arange(16, dtype=np.float32)
        self.ramp = np.concatenate([(lanes + 1) / np.float32(16), lanes])
        self.work = np.zeros((3, n), np.float32)
        self.stack = np.zeros((2, 4096), np.float32)
        self.settings, self.rungs, self.progress = np.zeros(6), np.zeros((8, 4)), np.zeros(14, np.int64)
        self.kept: tuple[tuple[Any, ...], Any] = ((), None)
        self._plain: Floats | None = None
        self._samples: dict[int, NDArray[np.float32]] = {}
        self._scratch: dict[tuple[int, int, int], tuple[Any, ...]] = {}
        self.reserve(64, 16)

    def reserve(self, solids: int, goals: int) -> None:
        """Room for so many, and more."""
        if solids > len(self.__dict__.get("rows", ())):
            solids = 1 << (solids - 1).bit_length()
            self.rows, self.near, self.number = np.zeros((solids, 16)), np.zeros(solids), np.zeros(5, np.int64)
            self.kinds, self.ranks = np.zeros(solids, np.int64), np.zeros(solids, np.int64)
        if goals >= len(self.__dict__.get("ends", ())):
            goals = 1 << goals.bit_length()
            self.ends, self.order = np.zeros((goals + 1, self.n), np.float32), np.zeros(goals, np.int64)

    def samples(self, seed: int) -> NDArray[np.float32]:
        """Halton points (SAMPLES, n) in the unit cube, moved round by a random shift unless the seed is 0."""
        if seed not in self._samples:
            if self._plain is None:
                self._plain = halton(SAMPLES, self.n)
            points = self._plain
            if seed:
                points = (points + np.random.default_rng(seed).uniform(size=self.n)) % 1.0
            self._samples = {seed: np.ascontiguousarray(points, np.float32)}
        return self._samples[seed]

    def scratch(self, frames_count: int, bodies: int, most: int) -> tuple[Any, ...]:
        """The scratch arrays of `_edge_kernels`, for groups of `most` balls."""
        key = frames_count, 3 * bodies + 4 * most, len(self.rows)
        if key not in self._scratch:
            frames = np.zeros(12 * 16 * key[0], np.float32)
            frames.reshape(-1, 16)[[0, 4, 8]] = 1.0  # the base: the identity
            self._scratch = {
                key: (
                    frames,
                    np.zeros(16 * key[1], np.float32),
                    np.zeros(max(key[2], most) + 1, np.int64),
                    self.stack,
                    self.ramp,
                    self.work,
                )
            }
        return self._scratch[key]


def halton(count: int, n: int) -> Floats:
    """Points 1 .. count of the Halton sequence (count, n) with the odd primes as bases."""
    primes: list[int] = []
    candidate = 3
    while len(primes) < n:
        if all(candidate % p for p in primes if p * p <= candidate):
            primes.append(candidate)
        candidate += 2
    points = np.zeros((count, n))
    for j, base in enumerate(primes):
        index, share = np.arange(1, count + 1), 1.0
        while index.any():
            share /= base
            points[:, j] += share * (index % base)
            index //= base
    return points


_LOCAL = threading.local()


def room_of(n: int) -> Room:
    """The memory of this thread for robots of n joints."""
    rooms = _LOCAL.__dict__.setdefault("rooms", {})
    if n not in rooms:
        rooms[n] = Room(n)
    return rooms[n]
