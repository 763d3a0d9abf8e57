"""Makes the pictures of the documentation from real reports (needs Chromium): python docs/images/make.py"""

from __future__ import annotations

import shutil
import sys
import tempfile
import time
from pathlib import Path

from playwright.sync_api import sync_playwright

from horosphere.cli._app import main

FOLDER = Path(__file__).resolve().parent
FLAGS = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
]


def picture(scene: str, wait: float) -> None:
    """Plans `scene`, opens the report without a network and keeps its upper part after `wait` seconds."""
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as driver:
        if main(["plan", scene, "--out", folder]) != 0:
            sys.exit(f"{scene} was not solved")
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        page = browser.new_context(offline=True, viewport={"width": 1000, "height": 720}).new_page()
        page.goto(f"file://{folder}/report.html")
        time.sleep(wait)
        player = page.frame_locator("iframe")
        player.locator("canvas").first.wait_for(timeout=60_000)
        if player.locator(".mantine-Notification-closeButton").count():
            player.locator(".mantine-Notification-closeButton").first.click()
        time.sleep(1.5)
        page.screenshot(path=FOLDER / f"{scene}.png", timeout=120_000)
        browser.close()


if __name__ == "__main__":
    for name in sys.argv[1:] or ("humanoid-reach", "panda-table", "nao-reach"):
        picture(name, 9.0)
