"""Imports point one way, in the text and at run time: `layers` is the table, this holds the code against it."""

import ast
import importlib.util
import json
import re
import subprocess
import sys
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from tests.contracts import layers
from tests.sampled_cases import sampled

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = {"usdsdg": layers.USDSDG, "usdsdg_physics": layers.PHYSICS, "usdsdg_render": layers.RENDER}
ROOMS = [(package, room) for package, table in PACKAGES.items() for room in table]
IMPORTABLE = [
    room
    for room in ROOMS
    if room[1] != "__main__" and (room not in layers.NEEDS or importlib.util.find_spec(layers.NEEDS[room]))
]
# Those that are loaded, each in a process of its own; what they import is read of all.
ALWAYS = {("usdsdg", "errors"), *((package, "__init__") for package in PACKAGES)}
LOADED = sorted({*sampled(IMPORTABLE, 12)} | ALWAYS)
# A member of a module by its name, as in `_part("usdsdg.app.app:App")`: an import inside a function.
NAMED = re.compile(r"(usdsdg\w*(?:\.\w+)+):\w+")
# Loads each module that is named on the command line in a process of its own, forked from one that has loaded nothing
# of the product; what it has loaded of other libraries is not loaded again for each.
LOADER = """
import json, os, sys
for name in BEFORE:
    __import__(name)
for name in sys.argv[1:]:
    sys.stdout.flush()
    if (child := os.fork()) == 0:
        __import__(name)
        print(json.dumps([name, sorted(m for m in sys.modules if m.split(".")[0] in PACKAGES or m in ENGINES)]))
        sys.stdout.flush()
        os._exit(0)
    if os.waitpid(child, 0)[1]:
        sys.exit(f"{name} cannot be imported")
"""


@cache
def modules() -> dict[str, Path]:
    """Every module of the product by its dotted name."""
    found = {}
    for package in PACKAGES:
        for path in (ROOT / package).rglob("*.py"):
            parts = path.relative_to(ROOT).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def room_of(module: str) -> tuple[str, str]:
    """("usdsdg", "stage") for "usdsdg.stage.paths"; the package itself is its own "__init__"."""
    package, _, rest = module.partition(".")
    return package, rest.split(".")[0] or "__init__"


@cache
def imports() -> dict[str, tuple[frozenset[str], frozenset[str]]]:
    """Module -> what of the product it imports: at its top, and inside functions."""
    return {name: (frozenset(top), frozenset(late)) for name, (top, late) in map(_imports, modules())}


def _imports(name: str) -> tuple[str, tuple[set[str], set[str]]]:
    top: set[str] = set()
    late: set[str] = set()

    def visit(node: ast.AST, found: set[str]) -> None:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.If) and "TYPE_CHECKING" in ast.dump(child.test):
                continue
            if isinstance(child, ast.ImportFrom) and child.module:
                full = [f"{child.module}.{alias.name}" for alias in child.names]
                found |= {each if each in modules() else child.module for each in full}
            elif isinstance(child, ast.Import):
                found |= {alias.name for alias in child.names}
            elif isinstance(child, ast.Constant) and (named := NAMED.fullmatch(str(child.value))):
                late.add(named[1])
            visit(child, late if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda) else found)

    visit(ast.parse(modules()[name].read_text(encoding="utf-8")), top)
    return name, (top & modules().keys(), late & modules().keys())


def late_rooms(module: str) -> set[tuple[str, str]]:
    """The rooms that the table lets `module` import inside functions; a whole package stands for all of its rooms."""
    wanted = layers.LATE.get(module, ("", ""))[0].split()
    return {
        room
        for each in wanted
        for room in ([r for r in ROOMS if r[0] == each] if each in PACKAGES else [room_of(each)])
    }


def allowed(package: str, room: str) -> set[tuple[str, str]]:
    """The rooms that a row of the table names, the row's own among them."""
    row = PACKAGES[package][room].split()
    found = {(package, room), *(room_of(each) if "." in each else (package, each) for each in row)}
    return found | {("usdsdg", each) for each in layers.OF_ENGINES} if package in layers.ENGINES else found


def below(room: tuple[str, str]) -> set[tuple[str, str]]:
    """All rooms that may be loaded along with one."""
    found = set()
    open_ = {room, ("usdsdg", "__init__")}
    while open_:
        each = open_.pop()
        found.add(each)
        open_ |= (allowed(*each) | {(each[0], "__init__")}) - found
    return found


def test_the_table_lists_every_package_and_root_module():
    listed = set(ROOMS)
    there = {room_of(name) for name in modules()}
    assert there == listed


def test_the_page_of_the_architecture_has_every_room_and_no_other():
    """In its picture or in the tables below it, which name rooms alone in their first column."""
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    _, picture, text = page.split("```", 2)
    tables = re.findall(r"^\| (`.*?`) \|", text.split("\n## ")[0], re.MULTILINE)
    named = {name for row in tables for name in re.findall(r"`(\w+)`", row)}
    rooms = {room for _, room in ROOMS} - {"__init__"}
    assert named <= rooms
    assert rooms <= named | set(re.findall(r"\w+", picture))
    names = re.search(r"import nothing of `usdsdg` but (.*?)\. ", page, re.DOTALL)
    assert re.findall(r"`(\w+)`", names[1]) == sorted(layers.OF_ENGINES)


def test_rows_name_only_what_stands_above_them():
    for table in PACKAGES.values():
        known = {"__init__"}
        for room, wanted in table.items():
            assert {each for each in wanted.split() if "." not in each} <= known, room
            known.add(room)


@pytest.mark.parametrize(("package", "room"), ROOMS)
def test_rooms_import_only_what_their_row_names(package, room):
    for name in modules():
        if room_of(name) == (package, room):
            top, late = imports()[name]
            wrong = {each for each in top if room_of(each) not in allowed(package, room)}
            assert not wrong, f"{name} imports {sorted(wrong)}"
            wrong = {each for each in late if room_of(each) not in allowed(package, room) | late_rooms(name)}
            assert not wrong, f"{name} imports {sorted(wrong)} inside a function"


def test_imports_inside_functions_that_the_table_names_are_there():
    for name, (wanted, why) in layers.LATE.items():
        late = {room_of(each) for each in imports()[name][1]}
        assert why
        for each in wanted.split():
            rooms = {room for room in ROOMS if room[0] == each} if each in PACKAGES else {room_of(each)}
            assert rooms & late, f"{name} does not import {each} inside a function"


def test_no_module_imports_itself_by_way_of_others():
    graph = {
        name: {each for each in top | late if room_of(each) not in late_rooms(name)}
        for name, (top, late) in imports().items()
    }
    tuple(TopologicalSorter(graph).static_order())  # raises CycleError


@cache
def loaded() -> dict[str, set[str]]:
    """Module -> everything of the product that is loaded after `import module` in a fresh process."""
    light, heavy = ["numpy"], ["newton", "warp", "trimesh"]
    found = {}
    for before, has_engines in ((light, False), (light + heavy, True)):
        rooms = [room for room in LOADED if (room[0] in layers.ENGINES) == has_engines]
        names = [f"{package}.{room}".removesuffix(".__init__") for package, room in rooms]
        source = f"PACKAGES, ENGINES, BEFORE = {tuple(PACKAGES)}, ('newton', 'warp'), {before}\n{LOADER}"
        done = subprocess.run([sys.executable, "-c", source, *names], capture_output=True, text=True, cwd=ROOT)
        assert done.returncode == 0, done.stderr
        found |= {name: set(modules) for name, modules in map(json.loads, done.stdout.splitlines())}
    return found


@pytest.mark.parametrize(("package", "room"), LOADED)
def test_what_is_loaded_is_what_the_table_lets_in(package, room):
    name = f"{package}.{room}".removesuffix(".__init__")
    wrong = {each for each in loaded()[name] - {"newton", "warp"} if room_of(each) not in below((package, room))}
    assert not wrong, f"import {name} loads {sorted(wrong)}"


def test_errors_load_alone():
    assert loaded()["usdsdg.errors"] == {"usdsdg", "usdsdg.errors"}


def test_engines_load_only_what_the_table_gives_to_all_of_their_rooms():
    for engine in layers.ENGINES:
        rooms = {room_of(name) for name in loaded()[engine] if name.startswith("usdsdg.")}
        assert rooms <= {("usdsdg", each) for each in layers.OF_ENGINES}


@pytest.mark.parametrize(
    "name",
    ["usdsdg", *(f"{package}.{room}" for package, room in LOADED if package == "usdsdg" and room != "__init__")],
)
def test_no_engine_is_loaded_before_a_frame_needs_it(name):
    assert not loaded()[name] & {"newton", "warp", *layers.ENGINES} - {"usdsdg_render", "usdsdg_render.settings"}


def test_only_the_command_line_imports_compat():
    compat = ("usdsdg", "compat")
    importers = {room_of(name) for name, both in imports().items() for found in both if compat in map(room_of, found)}
    assert importers <= {compat, ("usdsdg", "cli"), ("usdsdg", "session")}  # the session owns what shims keep


def test_the_stub_and_the_module_agree():
    import usdsdg

    stub = ast.parse((ROOT / "usdsdg" / "__init__.pyi").read_text(encoding="utf-8"))
    assigned = {node.targets[0].id: node.value for node in stub.body if isinstance(node, ast.Assign)}
    assert set(ast.literal_eval(assigned["__all__"])) == set(usdsdg.__all__) <= set(dir(usdsdg))
    assert all(getattr(usdsdg, name) is not None for name in usdsdg.__all__)
