"""Are the pins in requirements.txt made for the dependencies that pyproject.toml names? Works without a network."""

from __future__ import annotations

import re
import sys
import tomllib
from importlib.metadata import version
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parent.parent


def main() -> int:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    text = (ROOT / "requirements.txt").read_text()
    pins = {}
    for line in re.findall(r"^[A-Za-z0-9][^#\n]*==[^\\\n]+", text, flags=re.MULTILINE):
        pin = Requirement(line)
        if pin.marker is None or pin.marker.evaluate():
            pins[re.sub(r"[-_.]+", "-", pin.name).lower()] = next(iter(pin.specifier)).version
    head = next(line for line in text.splitlines() if "uv pip compile" in line)
    extras = re.findall(r"--extra (\S+)", head)
    wanted = list(project["project"]["dependencies"]) + list(project["dependency-groups"]["dev"])
    for extra in extras:
        wanted += project["project"]["optional-dependencies"][extra]
    bad = []
    for text_of in wanted:
        requirement = Requirement(text_of)
        name = re.sub(r"[-_.]+", "-", requirement.name).lower()
        if name not in pins:
            bad.append(f"{name} is not pinned")
        elif not requirement.specifier.contains(pins[name], prereleases=True):
            bad.append(f"{name}=={pins[name]} is outside {requirement.specifier}")
        elif version(name) != pins[name]:
            bad.append(f"{name}=={pins[name]} is pinned, {version(name)} is installed")
    if re.search(r"https?://|--(extra-)?index-url|--find-links", text):
        bad.append("requirements.txt names a registry")
    for line in bad:
        print(f"pins: {line}; renew with the command in the head of requirements.txt")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
