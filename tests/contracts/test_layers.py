"""Imports point one way: stage ← engines ← orchestrator; only the command line imports compat."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

# Package or module → what of the project it may import. The first matching entry counts.
ALLOWED = {
    "usdsdg/stage": ("usdsdg.stage", "usdsdg.errors"),
    "usdsdg/errors.py": (),
    "usdsdg_physics": ("usdsdg_physics", "usdsdg.stage", "usdsdg.errors"),
    "usdsdg_render": ("usdsdg_render", "usdsdg.stage", "usdsdg.errors"),
    "usdsdg/graph": (
        "usdsdg.graph",
        "usdsdg.arguments",
        "usdsdg.session",
        "usdsdg.stage",
        "usdsdg.errors",
    ),
    "usdsdg/annotators": (
        "usdsdg.annotators",
        "usdsdg.graph.sampling",  # the only source of randomness
        "usdsdg.session",
        "usdsdg.stage",
        "usdsdg.errors",
        "usdsdg.arguments",
    ),
    "usdsdg/writers": (
        "usdsdg.writers",
        "usdsdg.annotators",
        "usdsdg.session",
        "usdsdg.stage",
        "usdsdg.errors",
        "usdsdg.arguments",
    ),
}
ENGINES = ("warp", "newton")


def imported(path: Path) -> set[str]:
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return names


def files(prefix: str) -> list[Path]:
    path = ROOT / prefix
    return [path] if path.suffix == ".py" else sorted(path.rglob("*.py"))


@pytest.mark.parametrize("prefix", ALLOWED)
def test_packages_import_only_what_lies_below_them(prefix):
    allowed = ALLOWED[prefix]
    for path in files(prefix):
        for name in imported(path):
            if name.split(".")[0] in ("usdsdg", "usdsdg_physics", "usdsdg_render") and name != "usdsdg":
                assert name.startswith(allowed), f"{path.relative_to(ROOT)} imports {name}"


@pytest.mark.parametrize("package", ["usdsdg/stage", "usdsdg/graph", "usdsdg/writers"])
def test_no_engine_below_the_orchestrator(package):
    for path in files(package):
        assert not {name.split(".")[0] for name in imported(path)} & set(ENGINES), path


def test_only_the_command_line_imports_compat():
    for path in files("usdsdg"):
        inside = path.relative_to(ROOT).parts[1]
        if inside not in ("compat", "cli"):
            assert not any(name.startswith("usdsdg.compat") for name in imported(path)), path
