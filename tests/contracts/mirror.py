"""Compare our public names with the table of Replicator's names."""

from __future__ import annotations

import ast
import inspect
import json
import re
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import usdsdg
from tests.contracts.replicator_names import TABLE

LINE = re.compile(
    r"(?:(?P<version>\d\.\d) )?(?:(?P<kind>module|class|async) )?(?P<path>[\w.:]+)"
    r"(?P<signature>\(.*?\))?(?: = (?P<value>.+?))?(?: -> (?P<returns>\w+))?"
)
REGISTRIES = {"annotator": "annotators.get", "augmentation": "annotators.get_augmentation"}


@dataclass(frozen=True)
class Name:
    """One name of the table.

    path: below usdsdg ("create.sphere"), an import ("import omni.x:y"), or a registry's member
        ("annotators.get('rgb')").
    kind: "module", "class", "async", "import", "annotator", "augmentation", or "" for functions and values.
    signature: None when the specification gives none. more: parameters of other versions, by version.
    value: as source text; "" when it is not a value.
    """

    path: str
    section: str
    kind: str = ""
    signature: inspect.Signature | None = None
    value: str = ""
    returns: str = ""
    version: str = "1.12"
    more: tuple[tuple[str, inspect.Signature], ...] = ()


def parsed(text: str) -> inspect.Signature:
    """Parse a signature such as "(a, b=1)"."""
    scope: dict[str, Any] = {}
    exec(f"def f{text}: ...", scope)
    return inspect.signature(scope["f"])


def _name(section: str, module: str, line: str) -> Name:
    found = LINE.fullmatch(line)
    if not found:
        raise ValueError(f"{section} {module}: cannot read {line!r}")
    path, kind = found["path"], found["kind"] or ""
    if module == "import":
        path, kind = f"import {path}", "import"
    elif module in REGISTRIES:
        path, kind = f"{REGISTRIES[module]}('{path}')", module
    elif module:
        path = f"{module}.{path}"
    signature = parsed(found["signature"]) if found["signature"] else None
    return Name(
        path, section, kind, signature, found["value"] or "", found["returns"] or "", found["version"] or "1.12"
    )


@cache
def names() -> dict[str, Name]:
    """Return the names of the table by path, in order."""
    found: dict[str, Name] = {}
    for section, module, lines in TABLE:
        for line in (" ".join(line.split()) for line in lines.splitlines()):
            if not line:
                continue
            name = _name(section, module, line)
            first = found.get(name.path)
            if first is None:
                found[name.path] = name
            elif name.version == "1.12" or name.signature is None:
                raise ValueError(f"{name.path} is given twice in the table")
            else:
                found[name.path] = replace(first, more=(*first.more, (name.version, name.signature)))
    return found


# Objects whose attributes the table lists, which only functions return.
def _objects() -> dict[str, Any]:
    from usdsdg.session.render_products import HydraTexture

    return {"HydraTexture": HydraTexture("/Render/HydraTextures/rp", "/World/camera", (64, 64))}


# Words that an annotation of each return kind may contain.
RETURNS = {
    "annotator": ("Annotator",),
    "augmentation": ("Augmentation",),
    "backend": ("Backend",),
    "bool": ("bool",),
    "callback": ("StatusCallback",),
    "context": ("Iterator", "ContextManager", "Generator"),
    "dict": ("dict", "Mapping"),
    "item": ("Item", "Distribution"),
    "list": ("list",),
    "none": ("None",),
    "number": ("int", "float"),
    "prim": ("Prim",),
    "product": ("HydraTexture",),
    "stage": ("Stage",),
    "status": ("Status",),
    "string": ("str",),
    "writer": ("Writer",),
}
MISSING = "missing"
REFUSES = "raises Unsupported whatever it is given"


@cache
def differences() -> dict[str, str]:
    """Return differences by path: "missing", or what differs; names that agree with the table are left out."""
    found = {path: difference(name) for path, name in names().items() if name.kind != "import"}
    found |= _imports([path for path, name in names().items() if name.kind == "import"])
    return {path: found[path] for path in names() if found[path]}


def difference(name: Name) -> str:
    """Return how ours differs from one name of the table that is not an import; "" when it does not."""
    if name.kind == "annotator":
        return _annotator(name)
    if name.kind == "augmentation":
        return _found(lambda: usdsdg.annotators.get_augmentation(name.path.split("'")[1]))
    try:
        owner, ours = _resolved(name.path)
    except AttributeError:
        return MISSING
    return REFUSES if _refuses(ours) else "; ".join(_faults(name, owner, ours))


def _refuses(ours: Any) -> bool:
    """Return whether a function or class does nothing but raise Unsupported."""
    if (inspect.isclass(ours) or inspect.isfunction(ours)) and (ours.__doc__ or "").startswith("Unsupported:"):
        return True
    if not inspect.isfunction(ours):
        return False
    body = ast.parse(textwrap.dedent(inspect.getsource(ours))).body[0].body
    statements = [each for each in body if not (isinstance(each, ast.Expr) and isinstance(each.value, ast.Constant))]
    return len(statements) == 1 and isinstance(statements[0], ast.Raise) and "Unsupported" in ast.dump(statements[0])


def _found(ask: Any) -> str:
    try:
        ask()
    except usdsdg.errors.UsdsdgError:
        return MISSING
    return ""


def _annotator(name: Name) -> str:
    label = name.path.split("'")[1]
    if missing := _found(lambda: usdsdg.annotators.get(label)):
        return missing
    spec = usdsdg.annotators.get(label)._spec
    if _refuses(spec.compute):
        return REFUSES
    takes = spec.params
    wrong = []
    for parameter in name.signature.parameters.values() if name.signature else ():
        if parameter.name not in takes:
            wrong.append(f"has no init parameter {parameter.name}")
        elif not _same(parameter.default, takes[parameter.name]):
            wrong.append(f"{parameter.name} is {takes[parameter.name]!r}, not {parameter.default!r}")
    return "; ".join(wrong)


def _resolved(path: str) -> tuple[Any, Any]:
    """Return the owner of a path's last part and its value, which is `...` for attributes that instances get.

    Raises:
        AttributeError: there is no such attribute.
    """
    first, *rest = path.split(".")
    owner, ours = usdsdg, _objects().get(first) or getattr(usdsdg, first)
    for part in rest:
        owner = ours
        ours = getattr(owner, part, ...) if inspect.isclass(owner) and _sets(owner, part) else getattr(owner, part)
    return owner, ours


def _sets(owner: type, attribute: str) -> bool:
    """Return whether instances get `attribute`: it is annotated in the class, or a method assigns it."""
    assigned = re.compile(rf"self\.{attribute}\b[^=\n]*=[^=]")
    return any(
        attribute in inspect.get_annotations(base) or assigned.search(inspect.getsource(base))
        for base in owner.__mro__
        if base.__module__.startswith("usdsdg")
    )


def _faults(name: Name, owner: Any, ours: Any) -> Iterator[str]:
    if name.kind == "module" and not inspect.ismodule(ours):
        yield "is no module"
    if name.kind == "class" and not inspect.isclass(ours):
        yield "is no class"
    if name.kind == "async" and not inspect.iscoroutinefunction(ours):
        yield "cannot be awaited"
    if name.value:
        value = getattr(ours, "value", ours)
        if value != parsed(f"(x={name.value})").parameters["x"].default:
            yield f"is {value!r}, not {name.value}"
    if name.signature is None:
        return
    if not callable(ours):
        yield "cannot be called"
        return
    signature = _signature(owner, name.path.rsplit(".", 1)[-1], ours)
    yield from signature_faults(name.signature, signature)
    for version, parameters in name.more:
        lacking = [each for each in parameters.parameters if each not in signature.parameters]
        if lacking:
            yield f"{version}: has no parameter {', '.join(lacking)}"
    if name.returns and not _returns(name.returns, signature.return_annotation):
        yield f"returns {signature.return_annotation}, not {name.returns}"


def _signature(owner: Any, last: str, ours: Any) -> inspect.Signature:
    """Return the signature without the `self` of a function that is looked up in its class."""
    signature = inspect.signature(ours)
    if inspect.isclass(owner) and inspect.isfunction(inspect.getattr_static(owner, last)):
        return signature.replace(parameters=list(signature.parameters.values())[1:])
    return signature


def _returns(kind: str, annotation: Any) -> bool:
    """Return whether an annotation, if there is one, is of the kind."""
    text = annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)
    return annotation in (inspect.Signature.empty, "Any", Any) or any(word in text for word in RETURNS[kind])


def unread(name: Name) -> list[str]:
    """Return arguments that our function neither reads nor names in its docstring."""
    try:
        _, ours = _resolved(name.path)
    except AttributeError:
        return []
    function = inspect.unwrap(getattr(ours, "__init__" if inspect.isclass(ours) else "__func__", ours))
    if not inspect.isfunction(function) or not function.__module__.startswith("usdsdg") or _refuses(function):
        return []
    if function.__code__.co_filename.startswith("<"):
        return []
    (definition,) = ast.parse(textwrap.dedent(inspect.getsource(function))).body
    read = {node.id for statement in definition.body for node in ast.walk(statement) if isinstance(node, ast.Name)}
    if "locals" in read or not read:
        return []
    known = {*read, "self", "cls"}
    return [
        each
        for each in inspect.signature(function).parameters
        if each not in known and each not in (function.__doc__ or "")
    ]


def signature_faults(theirs: inspect.Signature, ours: inspect.Signature) -> Iterator[str]:
    """Yield the reasons why a call that fits `theirs` could behave differently with `ours`.

    Ours may have keyword-only options beyond theirs, and a default where theirs has none.
    """
    kinds = inspect.Parameter
    positional = [p for p in theirs.parameters.values() if p.kind is kinds.POSITIONAL_OR_KEYWORD]
    named = {p.name: p for p in theirs.parameters.values() if p.kind is kinds.KEYWORD_ONLY}
    our_positional = [
        p for p in ours.parameters.values() if p.kind in (kinds.POSITIONAL_OR_KEYWORD, kinds.POSITIONAL_ONLY)
    ]

    # Names and positions.
    wanted, got = [p.name for p in positional], [p.name for p in our_positional]
    nameless = {i for i, each in enumerate(wanted) if each.startswith("_") and i < len(got)}
    lacking = [each for i, each in enumerate(wanted) if i not in nameless and each not in ours.parameters]
    if lacking:
        yield f"has no parameter {', '.join(lacking)}"
    elif moved := [each for i, each in enumerate(wanted) if i not in nameless and got[i : i + 1] != [each]]:
        yield f"{moved[0]} is not parameter {wanted.index(moved[0])}"
    extra = [each for i, each in enumerate(got) if i not in nameless and each not in wanted and each not in named]
    if extra:
        yield f"{', '.join(extra)} can be given by position"

    # Names without an order, and every default.
    lacking = [each for each in named if each not in ours.parameters]
    if lacking:
        yield f"has no parameter {', '.join(lacking)}"
    for parameter in [*positional, *named.values()]:
        mine = ours.parameters.get(parameter.name)
        default = ... if parameter.default is kinds.empty else parameter.default
        if mine is not None and not _same(default, mine.default):
            yield f"{parameter.name} {_default(mine.default)}, not {_default(parameter.default)}"
    for p in ours.parameters.values():
        if p.kind is kinds.KEYWORD_ONLY and p.default is kinds.empty and p.name not in named and p.name not in wanted:
            yield f"{p.name} must be given"

    # **options
    for kind, sign in ((kinds.VAR_POSITIONAL, "*"), (kinds.VAR_KEYWORD, "**")):
        theirs_has, ours_has = (any(p.kind is kind for p in each.parameters.values()) for each in (theirs, ours))
        if theirs_has != ours_has and "_more" not in theirs.parameters:
            yield f"takes {sign}arguments" if ours_has else f"takes no {sign}arguments"


def _default(value: Any) -> str:
    return "must be given" if value is inspect.Parameter.empty else f"is {value!r}"


def _same(theirs: Any, ours: Any) -> bool:
    if theirs is ...:
        return True
    if isinstance(theirs, tuple):
        return isinstance(ours, (tuple, list)) and len(ours) == len(theirs) and all(map(_same, theirs, ours))
    if isinstance(theirs, bool) or theirs is None:
        return ours is theirs
    return not isinstance(ours, bool) and theirs == ours


def _imports(paths: list[str]) -> dict[str, str]:
    """Return which import paths fail, tried in a separate process with the old names installed."""
    code = """
    import importlib, json, sys
    import usdsdg.compat; usdsdg.compat.install()
    found = {}
    for path in json.loads(sys.argv[1]):
        module, _, name = path.removeprefix("import ").partition(":")
        try:
            loaded = importlib.import_module(module)
            found[path] = "" if not name or hasattr(loaded, name) else "missing"
        except ImportError:
            found[path] = "missing"
    print(json.dumps(found))
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code), json.dumps(paths)], capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout)
