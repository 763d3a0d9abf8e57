"""Signed distances to the obstacles of the plane and of R^n that are no shapes of space."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..numeric import nearest_rotation
from ..scenes import Aerofoil, EllipsoidND, Star

Floats = NDArray[np.float64]
CORNERS = 4096


def ellipsoid_distance(solid: EllipsoidND) -> Callable[[Floats], Floats]:
    """Exact to rounding and never above, in any dimension."""
    from ..shapes import ellipsoid_signed_distance

    assert solid.rotation is not None
    center, axes, rotation = solid.center, solid.semi_axes, nearest_rotation(solid.rotation)
    return lambda points: ellipsoid_signed_distance((points - center) @ rotation, axes)


def star_distance(star: Star) -> Callable[[Floats], Floats]:
    """To the polygon through points of the outline, less what the outline may bulge out of it: |curve''| step^2 / 8."""
    phi = np.linspace(0.0, 2.0 * np.pi, CORNERS, endpoint=False)
    r = star.radius * (1.0 + star.amplitude * np.cos(star.lobes * (phi - star.angle)))
    corners = star.center + r[:, None] * np.column_stack((np.cos(phi), np.sin(phi)))
    a, m = star.amplitude, star.lobes
    bend = star.radius * (1.0 + a + 2.0 * a * m + a * m * m)
    return _polygon(corners, bend)


def aerofoil_distance(foil: Aerofoil) -> Callable[[Floats], Floats]:
    """As for the star; on the circle |w''| <= R + k^2 (2 R^2 / m^3 + R / m^2) with m the least |P|."""
    R = abs(foil.k - foil.mu)
    P = foil.mu + R * np.exp(
        1j * np.linspace(0.0, 2.0 * np.pi, CORNERS, endpoint=False) + 1j * np.angle(foil.k - foil.mu)
    )
    w = (P + foil.k**2 / P) * np.exp(1j * foil.angle)
    least = abs(R - abs(foil.mu))
    bend = R + foil.k**2 * (2.0 * R**2 / least**3 + R / least**2)
    return _polygon(np.column_stack((w.real, w.imag)) + foil.center, bend)


def _polygon(corners: Floats, bend: float) -> Callable[[Floats], Floats]:
    """Signed distance (negative inside) to a closed polygon, less the bulge of the curve it stands for."""
    bulge = bend * (2.0 * np.pi / CORNERS) ** 2 / 8.0
    edges = np.roll(corners, -1, axis=0) - corners
    squares = np.maximum((edges**2).sum(axis=1), 1e-300)

    def distance(points: Floats) -> Floats:
        result = np.empty(len(points))
        for i, p in enumerate(points):
            to = p - corners
            t = np.clip((to * edges).sum(axis=1) / squares, 0.0, 1.0)
            away = to - t[:, None] * edges
            d = np.sqrt((away**2).sum(axis=1).min())
            # crossings of the ray to the right
            y0, y1 = corners[:, 1], corners[:, 1] + edges[:, 1]
            cut = (y0 > p[1]) != (y1 > p[1])
            x = corners[cut, 0] + (p[1] - y0[cut]) / edges[cut, 1] * edges[cut, 0]
            result[i] = (-d if np.count_nonzero(x > p[0]) % 2 else d) - bulge
        return result

    return distance
