"""Paths of joint 1 in the plane: even spacing, and the wave that keeps the posture from being singular."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ._world import Surroundings

Array = NDArray[np.float64]
STEP = 0.05  # of the mean link length: between points of the path


def resample(points: Array, step: float) -> Array:
    gaps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    keep = np.concatenate([[True], gaps > 1e-9])
    points = points[keep]
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = np.linspace(0.0, s[-1], max(2, int(np.ceil(s[-1] / step)) + 1))
    return np.stack([np.interp(at, s, points[:, 0]), np.interp(at, s, points[:, 1])], axis=1)


def weave(path: Array, around: Surroundings, amplitude: float, where: Array, size: float, required: float) -> Array:
    """The path with a wave across it `where` (k,) is 1, faded out at both ends and where there is no room for it."""
    length, step = 6.0 * size, STEP * size
    s = np.arange(len(path)) * step
    tangent = np.gradient(path, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    room = np.clip((around.of_points(path) - required - amplitude) / amplitude, 0.0, 1.0)
    window = np.minimum(np.clip(s / length, 0.0, 1.0), np.clip((s[-1] - s) / length - 0.5, 0.0, 1.0))
    wide = max(1, int(0.5 * length / step))
    room *= where
    room = np.convolve(np.pad(room, wide, mode="edge"), np.full(2 * wide + 1, 1.0 / (2 * wide + 1)), mode="valid")
    offset = amplitude * room * window * np.sin(2.0 * np.pi * s / length)
    return resample(path + offset[:, None] * np.stack([-tangent[:, 1], tangent[:, 0]], axis=1), step)
