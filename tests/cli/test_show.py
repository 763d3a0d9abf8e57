"""`horosphere show` serves the scene on this machine, and plans again what is dragged."""

import json
import os
import signal
import subprocess
import sys
import urllib.request

import numpy as np
import pytest

pytest.importorskip("viser", reason="the live view needs the extra `view`")


def test_served_until_interrupted(reach):
    words = [
        sys.executable,
        "-m",
        "horosphere",
        "show",
        "humanoid-reach",
        str(reach.folder / "trajectory.npz"),
        "--json",
    ]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        text = ""
        while not text.endswith("}\n"):
            line = process.stdout.readline()
            assert line, process.stderr.read()
            text += line
        address = json.loads(text)["address"]
        assert address.startswith("http://127.0.0.1:")
        opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
        assert b"<html" in opener.open(address, timeout=20).read()
        os.kill(process.pid, signal.SIGINT)
        assert process.wait(20) == 0
    finally:
        if process.poll() is None:
            process.kill()


def test_dragging_plans_again():
    from horosphere.planning import plan
    from horosphere.scenes import Scene
    from horosphere.viewer import LiveView

    view = LiveView(Scene.load("humanoid-reach"), plan)
    try:
        view.run(0.1)
        view.move("goal", [0.40, 0.10, -0.30])
        view.move("0", [0.35, 0.05, 0.0])
        view.run(0.1)
        np.testing.assert_allclose(view.scene.goal.position, [0.40, 0.10, -0.30])
        np.testing.assert_allclose(view.scene.obstacles[0].center, [0.35, 0.05, 0.0])
        assert "solved" in view._verdict.content
    finally:
        view.close()


def test_a_robot_with_sliders_and_as_a_page(tmp_path, capsys):
    from horosphere import robots
    from horosphere.cli._app import main
    from horosphere.viewer import RobotView

    assert main(["robot", "panda", "--out", str(tmp_path / "p.yaml"), "--view", str(tmp_path / "p.html")]) == 0
    assert "<html" in (tmp_path / "p.html").read_text()[:2000].lower()
    assert main(["show", str(tmp_path / "p.yaml"), "--seconds", "0.1", "--json"]) == 0
    assert '"scene": "panda"' in capsys.readouterr().out
    panda = robots.load("panda")
    view = RobotView(panda)
    try:
        spans = np.radians([[slider.min, slider.max] for slider, _ in view._sliders])
        np.testing.assert_allclose(spans.T, [panda.limits.lower, panda.limits.upper], atol=1e-12)
        assert spans.max() > np.pi  # joint 6 turns past half a turn
        before = np.array(view._moving[-1][0].position)
        view._sliders[3][0].value = -60.0
        view.run(0.2)
        assert not np.allclose(view._moving[-1][0].position, before)
        assert "nearest checked links" in view._text.content
    finally:
        view.close()
