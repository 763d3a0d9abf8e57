"""What horosphere makes of a robot, as a mapping of plain values (for tables and JSON)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._robot import Robot, require_robot


def describe(robot: Robot) -> dict[str, Any]:
    """Chain, limits, collision model and notes of a robot as plain values (str, float, list, None for no limit)."""
    names = require_robot(robot).link_names
    movers: dict[int, str] = {}
    for link in robot.links:
        movers.setdefault(link.coordinate, "")
        on_chain = link.coordinate >= 0 and (link.multiplier, link.offset) == (1.0, 0.0)
        if on_chain and not movers[link.coordinate]:
            movers[link.coordinate] = link.kind
    joints = []
    for k, name in enumerate(robot.joint_names):
        row: dict[str, Any] = {"name": name, "type": movers.get(k) or "revolute"}
        if (
            row["type"] == "revolute"
            and not np.isfinite(robot.limits.lower[k])
            and not np.isfinite(robot.limits.upper[k])
        ):
            row["type"] = "continuous"
        for key in ("lower", "upper", "velocity", "acceleration", "effort"):
            value = float(getattr(robot.limits, key)[k])
            row[key] = value if np.isfinite(value) else None
        row["moves"] = [link.name for link in robot.links if link.coordinate == k]
        joints.append(row)
    caps = robot.capsules
    bodies = [
        {
            "link": names[caps.link[k]],
            "shape": "sphere" if np.array_equal(caps.a[k], caps.b[k]) else "capsule",
            "length": float(np.linalg.norm(caps.b[k] - caps.a[k])),
            "radius": float(caps.radius[k]),
            "note": caps.note[k],
        }
        for k in range(len(caps))
    ]
    form = robot.closed_form
    return {
        "name": robot.name,
        "source": robot.source,
        "base": names[0],
        "tip": names[robot.tip],
        "tool": robot.tool.tolist(),
        "chain": [names[k] for k in robot.chain],
        "joints": joints,
        "closed_form": None if form is None else {"name": form[0], "parameters": dict(form[1])},
        "collision": {
            "bodies": bodies,
            "links": sorted({body["link"] for body in bodies}),
            "self_pairs": [[names[i], names[j]] for i, j in robot.self_pairs],
            "pairs": [
                {"links": [p.first, p.second], "checked": p.checked, "why": p.reason, "touching": p.touching}
                for p in robot.pair_table
            ],
            "static_links": sorted({names[k] for k in robot.capsules.link[robot.static_bodies]}),
            "allowed_obstacles": [list(pair) for pair in robot.allowed_obstacles],
        },
        "notes": list(robot.notes),
    }
