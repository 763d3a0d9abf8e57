"""Draws the pictures of docs/snake.md.

python docs/images/snake_pictures.py
"""

from pathlib import Path

from horosphere.scenes import Scene
from horosphere.snake import Snake, Surroundings, bracket_figure, motion_figure, navigate_scene, snake_of

HERE = Path(__file__).parent

if __name__ == "__main__":
    q = [0.1, 0.2, 0.3, 0.2, 0.5, -0.4, 0.8, -0.3, 0.1]
    bracket_figure(Snake(7), q, "1212", 0.2).savefig(HERE / "snake-word-1212.png", dpi=80)
    bracket_figure(Snake(7), q, "12", 0.3).savefig(HERE / "snake-word-12.png", dpi=80)
    scene = Scene.load("snake-slalom")
    result = navigate_scene(scene)
    around = Surroundings.of(list(scene.obstacles), None)
    motion_figure(snake_of(scene), result.motion, around, result.path).savefig(HERE / "snake-slalom.png", dpi=80)
