"""Tell for a foreign name whether it is supported, partial, missing or out of scope, and why.

What is missing on purpose, or different, is listed in GAPS.md. A name is there in part where its docstring says what it
refuses (`Raises: Unsupported: ...`), or where the module of `usdsdg.compat` that has it says so in a table:
`PARTIAL = {"name": "what is left out"}`.
"""

import ast
import importlib
import inspect
import re
import sys
import textwrap
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from types import ModuleType
from typing import Any

from usdsdg.annotators import named_annotators
from usdsdg.arguments import misplaced
from usdsdg.compat import finder, foreign_names
from usdsdg.compat.placeholders import PlaceholderModule, is_placeholder
from usdsdg.errors import UsdsdgError
from usdsdg.session.session import current
from usdsdg.writers import registry as writers

SUPPORTED, PARTIAL, MISSING, OUT_OF_SCOPE = "supported", "partial", "missing", "out of scope"
STATES = (SUPPORTED, PARTIAL, MISSING, OUT_OF_SCOPE)
REPLICATOR = "omni.replicator.core."
_OTHER_WRITERS = ("ROS1", "ROS2", "RtxLidar", "RtxRadar")  # of extensions that are out of scope
# An entry of the section "Raises" with its continued lines.
_REFUSED = re.compile(r"^ +(?:\w+, )*Unsupported(?:, \w+)*: (.*(?:\n {8,}.*)*)", re.MULTILINE)
# What the caller or the installation lacks, not we.
_NO_GAP = re.compile(
    r"as `|obstore is not|torch is not|a bucket without obstore\.|there is no such|Replicator has it|`\w+` is neither"
)
_REGISTERED = re.compile(r"(annotators|writers)\.get\('(.*)'\)")


@dataclass(frozen=True)
class Verdict:
    """State of a name, and for all but `supported` the reason, with a remedy where there is one."""

    state: str
    why: str = ""


@cache
def verdict(name: str) -> Verdict:
    """Return the verdict on a name, as a script would find it: `omni.usd.get_context`, `annotators.get('rgb')`."""
    finder.install()
    with _unnoticed():
        return _verdict(name)


@contextmanager
def _unnoticed() -> Iterator[None]:
    """Import names of Isaac Sim 4 without taking them for the script's: its own imports choose its payloads."""
    version, loaded = current().imported_version, set(sys.modules)
    try:
        yield
    finally:
        current().imported_version = version
        for name in [name for name in sys.modules if name not in loaded and name.startswith(finder.OLD_NAMES)]:
            parent, _, child = name.rpartition(".")
            del sys.modules[name]
            if parent == "omni.isaac":
                vars(sys.modules[parent]).pop(child, None)


def _verdict(name: str) -> Verdict:
    if registered := _REGISTERED.fullmatch(name):
        return _registered(*registered.groups())
    module, rest = _imported(name)
    if isinstance(module, PlaceholderModule):
        return Verdict(OUT_OF_SCOPE, _out_of_scope(name))
    if module is None:
        return _no_module(name)
    found: Any = module
    for part in rest:
        owner = found
        try:
            found = getattr(owner, part)
        except AttributeError:
            return Verdict(SUPPORTED) if _instances_have(owner, part) else _no_attribute(name, owner, part)
        if is_placeholder(found):
            return Verdict(OUT_OF_SCOPE, _out_of_scope(name))
        if not (inspect.ismodule(owner) or inspect.isclass(owner)):
            break  # of an object, which this does not judge
    if reason := _refusal(found):
        return Verdict(MISSING, _gap(name) or reason)
    if left_out := _partial(module, rest) or _gaps("Different on purpose").get(_short(name)) or _refused_uses(found):
        return Verdict(PARTIAL, left_out)
    return Verdict(SUPPORTED)


def is_known(name: str) -> bool:
    """Whether a name is no member of a registry, to which scripts add theirs, or one that Replicator has."""
    registered = _REGISTERED.fullmatch(name)
    if registered is None:
        return True
    family, member = registered.groups()
    return member in _reasons(family) or member.startswith(_OTHER_WRITERS)


def _reasons(family: str) -> Mapping[str, str]:
    """Return the registered names that are known and not here, with the reason."""
    return named_annotators.UNSUPPORTED if family == "annotators" else {}


def _imported(name: str) -> tuple[ModuleType | None, list[str]]:
    """Return the longest prefix of a name that is a module, and the parts after it."""
    parts, module, count = name.split("."), None, 0
    for end in range(1, len(parts) + 1):
        prefix = ".".join(parts[:end])
        if finder.lacks(prefix):
            break
        try:
            module, count = importlib.import_module(prefix), end
        except (ImportError, ValueError):
            break
        if isinstance(module, PlaceholderModule):
            break  # its names are classes; as a module, one would take the class's place for the script
    return module, parts[count:]


def _registered(family: str, name: str) -> Verdict:
    reasons, get = _reasons(family), named_annotators.get if family == "annotators" else writers.get
    if name.startswith(_OTHER_WRITERS) or "out of scope" in reasons.get(name, ""):
        return Verdict(OUT_OF_SCOPE, reasons.get(name, "it publishes to ROS or shows a lidar, which are out of scope"))
    if name in reasons:
        return Verdict(MISSING, reasons[name])
    try:
        get(name)
    except UsdsdgError as error:
        return Verdict(MISSING, str(error).partition(" Known: ")[0])
    return Verdict(SUPPORTED)


def _no_module(name: str) -> Verdict:
    if moved := foreign_names.moved(name):
        return Verdict(MISSING, f"elsewhere: {moved.where}")
    return Verdict(MISSING, "no such module")


def _instances_have(owner: Any, part: str) -> bool:
    """Return whether objects of a class get the attribute: it is annotated, or a method of the class assigns it."""
    if not inspect.isclass(owner):
        return False
    ours = [base for base in owner.__mro__ if base.__module__.startswith("usdsdg")]
    assigned = re.compile(rf"self\.{part}\b[^=\n]*=[^=]")
    return any(part in inspect.get_annotations(base) or assigned.search(inspect.getsource(base)) for base in ours)


def _no_attribute(name: str, owner: Any, part: str) -> Verdict:
    if moved := foreign_names.moved(name):
        return Verdict(MISSING, f"elsewhere: {moved.where}")
    if gap := _gap(name):
        return Verdict(MISSING, gap)
    known = getattr(owner, "__all__", None) or [each for each in dir(owner) if not each.startswith("_")]
    told = misplaced.hint(owner.__name__ if inspect.ismodule(owner) else "", part, known)
    return Verdict(MISSING, told.removeprefix("; "))


def _out_of_scope(name: str) -> str:
    subject = foreign_names.out_of_scope(name)
    return f"{subject.subject} out of scope. {subject.instead}" if subject else ""


def _partial(module: ModuleType, rest: list[str]) -> str:
    """Return what the module's own table `PARTIAL` says a name does not do."""
    table = vars(module).get("PARTIAL", {})
    return next((table[key] for end in (len(rest), 1) if (key := ".".join(rest[:end])) in table), "")


def _refusal(found: Any) -> str:
    """Return the reason of a function or class that does nothing but raise `Unsupported`, or ""."""
    doc = inspect.getdoc(found) or ""
    if (inspect.isclass(found) or inspect.isfunction(found)) and doc.startswith("Unsupported:"):
        return doc.removeprefix("Unsupported:").strip().partition("\n")[0]
    if not inspect.isfunction(found):
        return ""
    try:
        (definition,) = ast.parse(textwrap.dedent(inspect.getsource(found))).body
    except (OSError, TypeError, SyntaxError, ValueError):
        return ""
    body = getattr(definition, "body", [])
    lines = [each for each in body if not (isinstance(each, ast.Expr) and isinstance(each.value, ast.Constant))]
    only_raises = len(lines) == 1 and isinstance(lines[0], ast.Raise) and "Unsupported" in ast.dump(lines[0])
    return (doc.partition("\n")[0] or "it raises Unsupported") if only_raises else ""


def _refused_uses(found: Any) -> str:
    """Return the uses that a function or class refuses, by its docstring: `Unsupported: tiles, or deep pixels.`"""
    if not (inspect.isclass(found) or inspect.isroutine(found)):
        return ""
    docs = [inspect.getdoc(found) or ""]
    if inspect.isclass(found):
        docs.append(inspect.getdoc(found.__init__) or "")
    refused = [" ".join(reason.split()) for doc in docs for reason in _REFUSED.findall(doc)]
    told = " ".join(reason for reason in refused if not _NO_GAP.match(reason))
    return f"Unsupported: {told}" if told else ""


# --- GAPS.md ---


def _gap(name: str) -> str:
    """Return the reason and the remedy that GAPS.md has for a name of Replicator, or ""."""
    return _gaps("Missing on purpose").get(_short(name)) or _gaps("Different on purpose").get(_short(name)) or ""


def _short(name: str) -> str:
    return name.removeprefix(f"{REPLICATOR}scripts.").removeprefix(REPLICATOR)


@cache
def _gaps(section: str) -> dict[str, str]:
    """Return the reasons in a section of GAPS.md by name."""
    text = files("usdsdg.compat").joinpath("GAPS.md").read_text(encoding="utf-8")
    rows = re.split(r"^## ", text.partition(f"## {section}\n")[2], maxsplit=1, flags=re.MULTILINE)[0].splitlines()
    found = {}
    for row in rows:
        if row.startswith("| `"):
            names, why, *rest = (cell.strip() for cell in row.strip("|").split("|"))
            remedy = f"; {rest[0]}" if rest and rest[0] else ""
            found.update(dict.fromkeys(re.findall(r"`([^`]+)`", names), f"{why}{remedy}"))
    return found
