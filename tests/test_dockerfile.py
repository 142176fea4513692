"""Basics of the Dockerfile, which no test builds: its instructions, and that what it runs and copies is there."""

import re
import shlex
from pathlib import Path

from usdsdg.cli.app import app

ROOT = Path(__file__).resolve().parents[1]
INSTRUCTIONS = {"FROM", "ENV", "RUN", "COPY", "USER", "WORKDIR", "ENTRYPOINT", "CMD"}


def instructions() -> list[tuple[str, str]]:
    """Return (instruction, arguments) with continued lines joined, without comments."""
    text = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    lines = "\n".join(line for line in text.splitlines() if not line.startswith("#")).replace("\\\n", " ")
    return [tuple(line.split(None, 1)) for line in lines.splitlines() if line.strip()]


def arguments_of(name: str) -> list[str]:
    return [arguments for each, arguments in instructions() if each == name]


def test_images_are_pinned_to_a_tag_and_come_from_no_host_of_their_own():
    names = {arguments.split(" AS ")[1] for arguments in arguments_of("FROM")}
    assert {"cpu", "cuda"} <= names
    for image in (arguments.split()[0] for arguments in arguments_of("FROM")):
        assert image in names or re.fullmatch(r"[a-z]+:[\w.-]+", image), image
        assert not image.endswith(":latest")


def test_instructions_are_known_and_the_program_is_not_root():
    assert {name for name, _ in instructions()} <= INSTRUCTIONS
    order = [name for name, _ in instructions()]
    assert order.index("USER") < order.index("ENTRYPOINT")
    assert arguments_of("USER") == ["1000"]


def test_what_is_run_is_there_and_stops_at_the_first_failure():
    extras = set(re.findall(r"^(\w+) = \[", (ROOT / "pyproject.toml").read_text(encoding="utf-8"), re.MULTILINE))
    for line in arguments_of("RUN"):
        assert ";" not in line
        for part in (shlex.split(each) for each in line.split("&&")):
            if part[0] == "usdsdg":
                app.commands[part[1]].make_context(part[1], part[2:]).close()
            if part[:2] == ["pip", "install"]:
                (given,) = part[2:]
                assert set(given.partition("[")[2].rstrip("]").split(",")) <= extras


def test_the_build_context_has_what_the_package_is_built_from():
    ignored = (ROOT / ".dockerignore").read_text(encoding="utf-8").split()
    assert not {"pyproject.toml", "README.md", "LICENSE", "usdsdg", "usdsdg_physics", "usdsdg_render"} & set(ignored)
