"""The report opens from disk, without a network, in a real browser."""

import io
import re
import shutil
import time

import numpy as np
import pytest

import horosphere.scenes as sc
from horosphere import robots, shapes
from horosphere.viewer import report_html, robot_html
from horosphere.viewer._recording import ASPECT, draw, new_server

pytest.importorskip("viser", reason="the report needs the extra `view`")


def arm_report():
    scene = sc.Scene.load("humanoid-reach")
    u = np.linspace(0, 1, 40)[:, None]
    q = np.array([0.2, 1.2, 1.0, 0.3, 0.4]) * (1 - u) + np.array([-0.4, 2.0, 0.6, -0.3, -0.4]) * u
    trajectory = sc.Trajectory(2.0 * u[:, 0], q, names=scene.robot.joint_names)
    return report_html(scene, trajectory, solved=False, reason="<forearm> touches the ball", notes=("a & b",))


def plane_report():
    figures = [
        shapes.Ball([1, 0.5], 0.3),
        sc.EllipsoidND([2, 0], [0.4, 0.2], np.eye(2)),
        sc.Star([3, 1], 0.3),
        sc.Aerofoil([1, -1], 0.3, -0.03 + 0.02j),
    ]
    scene = sc.Scene(robot=sc.PointRobot(2, 0.1), start=[0, 0], goal=[4, 0], obstacles=figures, name="plane")
    return report_html(scene, sc.Trajectory([0, 1, 2], [[0, 0], [2, -2], [4, 0]]), solved=True)


def every_obstacle_report():
    solids = [
        shapes.Ball([1, 2, 3], 0.5),
        shapes.Ellipsoid([0, 0, 1], [0.1, 0.2, 0.3]),
        shapes.Capsule([0, 0, 0], [0, 1, 0], 0.1),
        shapes.Cylinder([0, 0, 0], [0, 1, 0], 0.1),
        shapes.Box([1, 1, 1], [0.1, 0.2, 0.3], name="a/b"),
        shapes.HalfSpace([0, 0, 1], -0.1),
        shapes.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]),
        shapes.PointCloud(np.random.default_rng(0).uniform(0, 1, (500_000, 3)), 0.01),
    ]
    scene = sc.Scene(robot="srs-arm", start=np.zeros(7), goal=np.full(7, 0.1), obstacles=solids)
    return report_html(scene, None, solved=False, reason="nothing tried")


def snake_report():
    scene = sc.Scene(
        robot=sc.SnakeRobot(np.ones(4), width=0.1),
        start=sc.PostureTarget(np.zeros(6)),
        goal=sc.PostureTarget([1, 1, 0, 0, 0, 0]),
    )
    return report_html(scene, sc.Trajectory([0, 1], [np.zeros(6), [1, 1, 0, 0.3, 0.2, 0.1]]), solved=True)


REPORTS = {"arm": arm_report, "plane": plane_report, "every obstacle": every_obstacle_report, "snake": snake_report}


@pytest.fixture(scope="module", params=REPORTS)
def report(request):
    return REPORTS[request.param]()


def test_one_file(report, capsys):
    assert len(report.encode()) < 5e6
    assert report.count("<html") == 1 and 'id="verdict"' in report  # the player is text inside srcdoc
    page = re.sub(r'srcdoc="[^"]*"', "", report)
    assert not re.findall(r'(?:src|href)="(?!data:|#)[^"]+"', page)
    ids = re.findall(r'\sid="([^"]+)"', page)
    assert len(ids) == len(set(ids))  # curves do not share clip paths
    assert capsys.readouterr().out == ""  # standard output is for results


def test_points_of_a_cloud_are_as_large_as_they_are_and_in_the_picture():
    """viser draws discs of twice `point_size` across, in metres of the scene."""
    points = np.array([[0.5, 0.0, 0.5], [0.0, 3.0, 0.5], [0.4, -0.2, 2.0]])
    drawn, server = [], new_server()
    try:
        server.scene.add_point_cloud = lambda name, p, color, **how: drawn.append((np.array(p), how))
        q = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.5, 0.7])
        scene = sc.Scene("panda", q, q, (shapes.PointCloud(points, 0.004), shapes.PointCloud(points + 0.1, 0.2)))
        draw(server, scene, q[None], None)
        camera = server.initial_camera
        back = np.subtract(camera.position, camera.look_at)
        away = points - camera.position
        ahead = -away @ back / np.linalg.norm(back)
        aside = np.sqrt((away**2).sum(axis=1) - ahead**2)
    finally:
        server.stop()
    assert [how["point_size"] for _, how in drawn] == [0.004, 0.2]
    assert all(how["point_shape"] == "circle" for _, how in drawn)
    assert (ahead > 0.0).all() and (aside / ahead < np.hypot(1.0, ASPECT) * np.tan(camera.fov / 2)).all()


def test_only_what_is_there_is_explained():
    q = np.array([0.7, 1.2, 1.0, 0.0, 0.0])
    scene = sc.Scene("humanoid-arm", q, q + 0.1)
    failed = re.sub(r'srcdoc="[^"]*"', "", report_html(scene, None, solved=False, reason="in the way"))
    for words in ("slider", "faint", "path of the tool", "obstacles</p>", "</span>obstacles"):
        assert words not in failed
    assert "</span>start<" in failed and "</span>goal<" in failed
    moving = re.sub(r'srcdoc="[^"]*"', "", report_html(scene, sc.Trajectory([0, 1], [q, q + 0.1])))
    assert "its last 0.8 s the robot rests" in moving and "start (its posture faint)" in moving


def test_the_page_of_a_robot_says_whose_it_is():
    page = re.sub(r'srcdoc="[^"]*"', "", robot_html(robots.load("humanoid-arm")))
    assert "<title>humanoid-arm</title>" in page and "<h1>humanoid-arm</h1>" in page
    assert "5 joints; 3 collision bodies on 3 links" in page


def test_text_is_escaped():
    page = arm_report()
    assert "Not solved: &lt;forearm&gt; touches the ball" in page and "a &amp; b" in page


BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


@pytest.mark.skipif(BROWSER is None, reason="no Chromium on this machine")
def test_in_a_browser_without_network(tmp_path):
    playwright = pytest.importorskip("playwright.sync_api")
    from PIL import Image

    path = tmp_path / "report.html"
    path.write_text(arm_report(), encoding="utf-8")
    wrong, asked = [], []
    flags = [
        "--no-sandbox",
        "--use-gl=angle",
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
        "--ignore-gpu-blocklist",
    ]
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=BROWSER, args=flags)
        page = browser.new_context(offline=True, viewport={"width": 560, "height": 620}).new_page()
        page.on("console", lambda message: wrong.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.on("requestfailed", lambda request: wrong.append(request.url))
        page.on("request", lambda request: asked.append(request.url))
        page.goto(path.as_uri())
        assert page.locator("#verdict").inner_text() == "Not solved: <forearm> touches the ball"
        assert page.locator(".card svg").count() == 3
        canvas = page.frame_locator("iframe").locator("canvas").first
        canvas.wait_for(state="visible", timeout=60_000)
        canvas.evaluate("element => element.scrollIntoView()")
        box = canvas.bounding_box(timeout=60_000)
        seen, deadline = [], time.monotonic() + 60
        while time.monotonic() < deadline:
            time.sleep(1.5)
            # of the page: an element's own waits until it stands still, for minutes on a busy machine without a GPU
            image = Image.open(io.BytesIO(page.screenshot(clip=box, timeout=90_000))).convert("RGB")
            seen.append(np.asarray(image, dtype=int)[60:-60])  # without the slider
            if blue_and_orange(seen[-1]) and (seen[-1] != seen[0]).any():
                break
        browser.close()
    assert blue_and_orange(seen[-1]), "neither robot nor obstacle is seen"
    assert (seen[-1] != seen[0]).any(), "nothing moves"
    assert not wrong
    assert {url.split(":")[0] for url in asked} <= {"file", "data", "blob"}


def blue_and_orange(pixels):
    """Are the robot's blue and the obstacle's orange both in the picture?"""
    red, green, blue = pixels[..., 0], pixels[..., 1], pixels[..., 2]
    return ((blue > red + 40) & (blue > green)).sum() > 200 and ((red > blue + 60) & (red > green + 30)).sum() > 200
