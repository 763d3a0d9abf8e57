"""Which cells of a grid a set of triangles meets: compiled code."""

from __future__ import annotations

import math

from ..kernels import jit


@jit
def mark_cells(triangles, size, grid):
    """Sets grid (k, l, m) where a triangle (t, 3, 3) meets or touches the cell; the grid starts at 0, cells are `size` (3,).

    Separating axes of a triangle and a box: 3 of the box, the normal, 9 edge x axis.
    """
    v = triangles.copy()
    for t in range(triangles.shape[0]):
        for c in range(3):
            for r in range(3):
                v[t, c, r] = triangles[t, c, r] / size[r]  # in units of cells: boxes become cubes
    tiny = 1e-9
    for t in range(v.shape[0]):
        a, b, c = v[t, 0], v[t, 1], v[t, 2]
        nx = (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1])
        ny = (b[2] - a[2]) * (c[0] - a[0]) - (b[0] - a[0]) * (c[2] - a[2])
        nz = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        reach = 0.5 * (abs(nx) + abs(ny) + abs(nz))
        low = [0, 0, 0]
        high = [0, 0, 0]
        for r in range(3):
            low[r] = max(int(math.floor(min(a[r], min(b[r], c[r])) - tiny)), 0)
            high[r] = min(int(math.floor(max(a[r], max(b[r], c[r])) + tiny)), grid.shape[r] - 1)
        for i in range(low[0], high[0] + 1):
            for j in range(low[1], high[1] + 1):
                for k in range(low[2], high[2] + 1):
                    if grid[i, j, k]:
                        continue
                    x, y, z = i + 0.5, j + 0.5, k + 0.5
                    off = nx * (x - a[0]) + ny * (y - a[1]) + nz * (z - a[2])
                    if abs(off) > reach * (1.0 + tiny) + tiny:
                        continue
                    apart = False
                    for e in range(3):
                        p, q = v[t, e], v[t, (e + 1) % 3]
                        ex, ey, ez = q[0] - p[0], q[1] - p[1], q[2] - p[2]
                        for axis in range(3):
                            if axis == 0:
                                dx, dy, dz = 0.0, -ez, ey
                            elif axis == 1:
                                dx, dy, dz = ez, 0.0, -ex
                            else:
                                dx, dy, dz = -ey, ex, 0.0
                            half = 0.5 * (abs(dx) + abs(dy) + abs(dz))
                            first = dx * (a[0] - x) + dy * (a[1] - y) + dz * (a[2] - z)
                            second = dx * (b[0] - x) + dy * (b[1] - y) + dz * (b[2] - z)
                            third = dx * (c[0] - x) + dy * (c[1] - y) + dz * (c[2] - z)
                            lowest, highest = min(first, min(second, third)), max(first, max(second, third))
                            if lowest > half + tiny or highest < -half - tiny:
                                apart = True
                    if not apart:
                        grid[i, j, k] = True
