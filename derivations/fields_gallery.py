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
from horosphere.fields._plot_space import plot_space
from horosphere.scenes import Scene

ROOT = Path(__file__).resolve().parents[1]


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
    figure, axes = plt.subplots(1, 2, figsize=(12.5, 6.0), layout="constrained")
    for ax, name, title in zip(
        axes, ("rn-fig2a-abrupt", "rn-fig2b-smooth"), ("abrupt switching", "shared in a boundary layer")
    ):
        scene, field = field_of(name)
        field.plot(field.trace(scene.start.position, step=0.04), ax=ax, title=title)
    axes[1].get_legend().remove()
    figure.savefig(folder / "field-rn-fig2.png", dpi=85)


def operation_plane(folder):
    scene, field = field_of("rn-fig3-operation-plane")
    start, goal, center = scene.start.position, field.goal, field.world.centers[0]
    path = field.trace(start, step=0.02)
    figure = plt.figure(figsize=(11, 5), layout="constrained")
    ax = figure.add_subplot(1, 2, 1, projection="3d")
    a = (start - goal) / np.linalg.norm(start - goal)
    b = (center - goal) - ((center - goal) @ a) * a
    b /= np.linalg.norm(b)
    s, t = np.meshgrid([-0.5, 4.2], [-1.4, 1.4])
    ax.plot_surface(*np.moveaxis(goal + s[..., None] * a + t[..., None] * b, -1, 0), color="#e8c07d", alpha=0.25)
    plot_space(field, path, ax=ax, lines=0, title="the motion in space, its plane")
    out = np.cross(a, b)
    flat = HarmonicField([0.0, 0.0], ([[center @ a, center @ b]], [field.world.radii[0]]))
    flat.plot(
        np.stack([path.points @ a, path.points @ b], axis=-1),
        ax=figure.add_subplot(1, 2, 2),
        title="the same in the plane",
    ).get_legend().remove()
    print(f"fig 3: the path leaves the plane by {np.abs(path.points @ out).max():.1e} m")
    figure.savefig(folder / "field-rn-fig3.png", dpi=85)


def space(name, file, folder, title):
    scene, field = field_of(name)
    axes = field.plot(field.trace(scene.start.position, step=0.01), title=title)
    axes.figure.savefig(folder / file, dpi=85)
    plt.close(axes.figure)


def conformal(folder):
    figure, axes = plt.subplots(1, 3, figsize=(16, 4.9), layout="constrained")
    for ax, letter, title in zip(axes, "abc", ("ellipse", "turned ellipse", "aerofoil")):
        scene, field = field_of(f"field-humanoid-fig6{letter}")
        field.plot(field.trace(scene.start.position, step=0.02), ax=ax, title=title, extent=(-4, 5, -3.2, 3.2))
    axes[0].get_legend().remove(), axes[2].get_legend().remove()
    figure.savefig(folder / "field-humanoid-fig6.png", dpi=80)


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
    space("rn-fig4-three-obstacles", "field-rn-fig4-5.png", folder, "motion among three obstacles")
    runpy.run_path(str(ROOT / "derivations" / "fields_revolute_arm.py"))["picture"](folder)
    space("field-humanoid-fig3", "field-humanoid-fig3.png", folder, "gradient lines around a ball")
    conformal(folder)
    stars(folder)
