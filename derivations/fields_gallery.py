"""Draw the figures of [Rn] and [Humanoid] VI-VII, as they come out here, from the built-in scenes.

python derivations/fields_gallery.py [DIR]        default docs/images
"""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from horosphere.fields import HarmonicField, random_world
from horosphere.scenes import Scene

ROOT = Path(__file__).resolve().parents[1]
COLORS = ("#33658a", "#0b6e4f", "#e09f3e", "#d1495b")


def field_of(name, **changes):
    scene = Scene.load(name)
    margin = scene.robot.radius + scene.options.clearance
    options = {"boundary": scene.field.boundary, "blend": scene.field.blending, "margin": margin, **changes}
    return scene, HarmonicField(scene.goal.position, scene.obstacles, **options)


def planar(name, file, folder, title, **options):
    scene, field = field_of(name)
    axes = field.plot(field.trace(scene.start.position, step=0.02), title=title, **options)
    axes.figure.savefig(folder / file, dpi=85)
    plt.close(axes.figure)


def two_obstacles(folder):
    figure, axes = plt.subplots(1, 2, figsize=(12.5, 5.4), layout="constrained")
    for ax, name, title in zip(
        axes, ("rn-fig2a-abrupt", "rn-fig2b-smooth"), ("abrupt switching", "shared in a boundary layer")
    ):
        scene, field = field_of(name)
        field.plot(field.trace(scene.start.position, step=0.04), ax=ax, title=title)
    figure.savefig(folder / "field-rn-fig2.png", dpi=85)


def balls_3d(ax, field):
    u, v = np.mgrid[0 : 2 * np.pi : 40j, 0 : np.pi : 20j]
    ball = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], axis=-1)
    for center, radius in zip(field.world.centers, field.world.radii):
        ax.plot_surface(*np.moveaxis(center + radius * ball, -1, 0), color="#8aa0b8", alpha=0.45, linewidth=0)
    ax.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")


def finish_3d(ax, points, goal):
    """The motion with its ends, one scale on all axes (after everything is drawn), room for the labels."""
    ax.plot(*points.T, color="#d1495b", linewidth=2.2, label="motion")
    ax.plot(*points[0][:, None], "s", color="#d1495b", markersize=6, label="start")
    ax.plot(*goal[:, None], "*", color="#0b6e4f", markersize=13, label="goal")
    ax.set_box_aspect([np.ptp(limits) for limits in (ax.get_xlim(), ax.get_ylim(), ax.get_zlim())], zoom=0.87)
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.set_major_locator(plt.MaxNLocator(4))
    ax.legend(loc="upper left", frameon=False, fontsize=8)


def operation_plane(folder):
    scene, field = field_of("rn-fig3-operation-plane")
    start, goal, center = scene.start.position, field.goal, field.world.centers[0]
    path = field.trace(start, step=0.02)
    figure = plt.figure(figsize=(11, 5), layout="constrained")
    ax = figure.add_subplot(1, 2, 1, projection="3d")
    balls_3d(ax, field)
    a = (start - goal) / np.linalg.norm(start - goal)
    b = (center - goal) - ((center - goal) @ a) * a
    b /= np.linalg.norm(b)
    s, t = np.meshgrid([-0.5, 4.2], [-1.4, 1.4])
    ax.plot_surface(*np.moveaxis(goal + s[..., None] * a + t[..., None] * b, -1, 0), color="#e8c07d", alpha=0.25)
    finish_3d(ax, path.points, field.goal)
    ax.set_title("the motion in space, its plane")
    out = np.cross(a, b)
    flat = HarmonicField([0.0, 0.0], ([[center @ a, center @ b]], [field.world.radii[0]]))
    flat.plot(
        np.stack([path.points @ a, path.points @ b], axis=-1),
        ax=figure.add_subplot(1, 2, 2),
        title="the same in the plane",
    )
    print(f"fig 3: the path leaves the plane by {np.abs(path.points @ out).max():.1e} m")
    figure.savefig(folder / "field-rn-fig3.png", dpi=85)


def three_obstacles(folder):
    scene, field = field_of("rn-fig4-three-obstacles")
    path = field.trace(scene.start.position, step=0.01)
    figure = plt.figure(figsize=(11, 5), layout="constrained")
    grid = figure.add_gridspec(2, 2, height_ratios=[3, 1], width_ratios=[1.15, 1])
    ax = figure.add_subplot(grid[:, 0], projection="3d")
    balls_3d(ax, field)
    finish_3d(ax, path.points, field.goal)
    ax.set_title("motion among three obstacles")
    upper, lower = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path.points, axis=0), axis=1))])
    distances, weights = field.world.clearances(path.points), field.weights(path.points)
    for k, name in enumerate(field.names):
        upper.plot(way, distances[:, k], color=COLORS[k], label=name)
        counted = np.where(weights[:, k] > 0, k + 1.0, np.nan)
        lower.plot(way, counted, color=COLORS[k], linewidth=5, solid_capstyle="butt")
    upper.set(ylabel="distance to the zone [m]", title="distances, and which obstacles count")
    upper.legend(frameon=False)
    lower.set(xlabel="way [m]", yticks=[1, 2, 3], yticklabels=field.names, ylim=(0.5, 3.5))
    figure.savefig(folder / "field-rn-fig4-5.png", dpi=85)


def humanoid_ball(folder):
    scene, field = field_of("field-humanoid-fig3")
    paths = [
        field.trace(scene.start.position + d, step=0.005)
        for d in np.random.default_rng(1).uniform(-0.12, 0.12, (14, 3))
    ]
    figure = plt.figure(figsize=(6, 5.6), layout="constrained")
    ax = figure.add_subplot(projection="3d")
    balls_3d(ax, field)
    for path in paths:
        ax.plot(*path.points.T, color="#1b2a41", linewidth=0.8)
    finish_3d(ax, field.trace(scene.start.position, step=0.005).points, field.goal)
    ax.set_title("gradient lines around a ball")
    figure.savefig(folder / "field-humanoid-fig3.png", dpi=85)


def conformal(folder):
    figure, axes = plt.subplots(1, 3, figsize=(16, 5), layout="constrained")
    for ax, letter, title in zip(axes, "abc", ("ellipse", "turned ellipse", "aerofoil")):
        scene, field = field_of(f"field-humanoid-fig6{letter}")
        field = HarmonicField(scene.goal.position, [joukowski(scene.obstacles[0])], margin=0.01)
        field.plot(field.trace(scene.start.position, step=0.02), ax=ax, title=title, extent=(-4, 5, -3.2, 3.2))
    figure.savefig(folder / "field-humanoid-fig6.png", dpi=80)


def joukowski(shape):
    from horosphere.maps import Joukowski

    if hasattr(shape, "k"):
        return Joukowski.aerofoil(shape.k, shape.mu, shape.center, shape.angle)
    return Joukowski.ellipse(*shape.semi_axes, shape.center, shape.angle)


def stars(folder):
    world = random_world("lobed-stars", 3)
    field = HarmonicField(world.goal, world.obstacles)
    axes = field.plot(field.trace(world.start), title="stars by the shell map")
    axes.figure.savefig(folder / "field-lobed-stars.png", dpi=85)


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "images"
    folder.mkdir(parents=True, exist_ok=True)
    planar("rn-fig1-basic", "field-rn-fig1.png", folder, "goal and one obstacle")
    two_obstacles(folder)
    operation_plane(folder)
    three_obstacles(folder)
    runpy.run_path(str(ROOT / "derivations" / "fields_revolute_arm.py"))["picture"](folder)
    humanoid_ball(folder)
    conformal(folder)
    stars(folder)
