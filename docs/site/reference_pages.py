"""Pages of the reference: docstrings, each with the example of docs/reference that a test runs."""

from __future__ import annotations

import ast
from pathlib import Path

from docs.site.cells import SETTING, Cell, cells
from docs.site.repository_pages import ROOT

EXAMPLES = ROOT / "docs" / "reference"
FAMILIES = ("create", "modify", "randomizer", "distribution", "trigger", "physics")
# Modules that tell what several members have in common.
SHARED = {"create": "usdsdg.create.shapes"}
# Modules without examples of their own: what they have is shown in tutorials.
MODULES = {
    "get": "usdsdg.get",
    "orchestrator": "usdsdg.orchestrator",
    "settings": "usdsdg.settings",
    "functional": "usdsdg.functional.modify",
    "stream": "usdsdg.stream",
    "errors": "usdsdg.errors",
}


def pages() -> dict[str, str]:
    """Return the generated pages by their names in the site."""
    made = {f"reference/{family}.md": _family(family) for family in FAMILIES}
    made |= {f"reference/{name}.md": f"# {name}\n\n::: {path}\n" for name, path in MODULES.items()}
    made["reference/annotators.md"] = _annotators()
    made["reference/writers.md"] = _writers()
    return made


def _code(cell: Cell) -> str:
    return f"```python\n{cell.code}```\n"


def _begin(title: str, about: str, program: Path) -> tuple[str, list[Cell]]:
    """Return the beginning of a page with what its examples need, and the other cells."""
    setting, *others = cells(program)
    assert setting.names == (SETTING,)
    return f"# {title}\n\n{about}\n\nThe examples of this page begin with\n\n{_code(setting)}\n", others


def _family(name: str) -> str:
    """Return the page of a family of functions; a member stands where its example does."""
    told = [f"usdsdg.{name}", *([SHARED[name]] if name in SHARED else [])]
    about = "\n\n".join(ast.get_docstring(ast.parse(_source(module))) or "" for module in told)
    text, others = _begin(f"rep.{name}", about, EXAMPLES / f"{name}.py")
    for cell in others:
        text += "".join(f"::: usdsdg.{name}.{member}\n\n" for member in cell.names)
        text += f"Example:\n\n{_code(cell)}\n"
    return text


def _source(module: str) -> str:
    path = ROOT / module.replace(".", "/")
    file = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    return file.read_text(encoding="utf-8")


def _annotators() -> str:
    """Return the page of all annotators: what each gives, as its function says, and the example of its group."""
    from usdsdg.annotators.base import annotator_specs

    about = (
        "`rep.annotators.get(NAME, init_params={...})`, attached to a render product, gives for each frame what is "
        "said here. N is the number of rows, H and W are the height and width of the picture."
    )
    text, others = _begin("Annotators", about, EXAMPLES / "annotators.py")
    for cell in others:
        text += f"## {', '.join(cell.names)}\n\n"
        told: list[str] = []
        for name in cell.names:
            spec = annotator_specs.get(name)
            if spec.documentation not in told:
                told.append(spec.documentation)
                given = ", ".join(f"`{key}={value!r}`" for key, value in spec.params.items())
                text += f"**{name}**: {_plain(spec.documentation)}\n\n" + (f"Parameters: {given}.\n\n" if given else "")
        text += f"{_code(cell)}\n"
    return text


def _plain(documentation: str) -> str:
    """Return a docstring as paragraphs of Markdown."""
    return "\n".join(line.strip() for line in documentation.replace("<", "&lt;").splitlines())


def _writers() -> str:
    """Return the page of all writers: the arguments of `initialize`, which are those of the class."""
    from usdsdg.writers import get_writers

    about = "`rep.writers.get(NAME)` makes a writer, whose `initialize` takes the arguments that are listed here."
    text, others = _begin("Writers", about, EXAMPLES / "writers.py")
    kinds = get_writers()
    for cell in others:
        (name,) = cell.names
        text += f"{_with_members(f'{kinds[name].__module__}.{name}', '__init__')}Example:\n\n{_code(cell)}\n"
    return text + _with_members("usdsdg.writers.Writer", "initialize, attach, detach, write, skip, on_final_frame")


def _with_members(path: str, members: str) -> str:
    """Return the line that stands for the documentation of a class and some of its members."""
    return f"::: {path}\n    options:\n      members: [{members}]\n\n"
