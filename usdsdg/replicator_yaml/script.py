"""Run a Replicator YAML file: calls of `rep`, names for their results, `with` blocks, registered functions."""

import inspect
import math
from collections import ChainMap
from collections.abc import Callable, MutableMapping
from pathlib import Path
from typing import Any

import yaml

import usdsdg
from usdsdg.errors import UsdsdgError
from usdsdg.graph.evaluate import graph
from usdsdg.graph.node import made_at
from usdsdg.replicator_yaml.document import INHERIT, Document, entries, hint, items, merged, plain, read_document
from usdsdg.replicator_yaml.errors import ParserError, fail
from usdsdg.replicator_yaml.public_names import (
    FAMILIES,
    public_function,
    public_functions,
    public_method,
    public_methods,
)
from usdsdg.session.settings.store import lets_files_run_code

Scope = MutableMapping[str, Any]

# Arguments whose strings are never names of groups.
TEXT = frozenset(
    {"name", "fn_name", "semantics", "semantics_exclusion", "light_type", "projection_type", "mode", "modify_type"}
    | {"path_pattern", "path_match", "path_pattern_exclusion", "prim_types", "prim_types_exclusion", "event_name"}
    | {"setting", "antialiasing", "up_axis", "approximation_shape", "rotation_order", "category"}
)

MAX_CALLS = 4000  # of a file
MAX_DEPTH = 20  # of functions that the file registers and that call each other

# The keys of a path relative to a file root or a Nucleus server.
PATH = {"value", "property"}


def parse(
    yaml_path: str | Path, root_dir: str | Path | None = None, nucleus_server: str | None = None
) -> dict[str, Any]:
    """Build what a Replicator YAML file describes, on the current stage; nothing is captured yet.

    Run it with `orchestrator.run_until_complete()`, or the file itself with `usdsdg run FILE`.

    Args:
        yaml_path: the file.
        root_dir: base of relative paths, that of the file too; by default its own folder. `file_root_dir` in the
            file is relative to it.
        nucleus_server: prefix of paths with the property "nucleus_path", instead of the file's own.

    Returns:
        the result of each group, by name.

    Raises:
        ParserError: the file cannot be read, or a call in it fails; the message names file and line.
    """
    path = Path(yaml_path)
    root = None if root_dir is None else Path(root_dir)
    if root is not None and not path.is_file():
        path = root / path
    return Script(read_document(path, root=root, nucleus=nucleus_server)).run()


def run_file(path: str | Path) -> None:
    """Build what a file describes and capture until every trigger with `max_execs` has run out.

    The timeline plays if a trigger fires by time.

    Raises:
        ParserError: as `parse`, or no trigger has `max_execs`, so that the run would not end.
    """
    from usdsdg import orchestrator

    parse(path)
    triggers = graph().triggers
    if not any(trigger.max_execs for trigger in triggers):
        raise ParserError(f"Error parsing {path}: no trigger has max_execs, so nothing would end the run; give one")
    orchestrator.run_until_complete(start_timeline=any(trigger.kind == "OgnOnTime" for trigger in triggers))
    orchestrator.wait_until_complete()


class Script:
    """Executes a document; results of groups are kept by name."""

    def __init__(self, document: Document) -> None:
        self._document = document
        self._made: dict[str, Any] = {}
        self._calls_left: float = MAX_CALLS  # until the file is read
        self._depth = 0  # registered functions that are running

    def run(self) -> dict[str, Any]:
        """Run all groups in order."""
        for name, group in self._document.groups.items():
            self._made[name] = self._group(group, self._made)
        self._calls_left = math.inf  # functions that it registered may be called for as long as the script runs
        return self._made

    # --- groups and blocks ---
    def _group(self, node: yaml.Node, scope: Scope) -> Any:
        """Return the result of a group: that of its last call, or its plain value."""
        if not isinstance(node, yaml.MappingNode):
            return self._value(node, scope)
        block = self._entries(node)
        if any("." in name for name in block):
            return self._block(block, scope)
        if block.keys() == PATH:
            return self._path(block)
        return {name: self._group(value, scope) for name, value in block.items()}

    def _block(self, block: dict[str, yaml.Node], scope: Scope) -> Any:
        """Run calls, `with` blocks and groups in order; return the result of the last that is not a `with` block."""
        made = None
        for name, node in block.items():
            if name.startswith("with."):
                self._with(name.removeprefix("with."), node, scope)
            elif name == "randomizer.register":
                self._register(node, scope)
            elif "." in name:
                made = self._call(name, node, scope)
            else:
                made = scope[name] = self._group(node, scope)
        return made

    def _with(self, name: str, node: yaml.Node, scope: Scope) -> None:
        if name not in scope and name not in self._document.templates:
            fail(node, f"with.{name}: there is no group {name!r} before this line{hint(name, scope)}")
        item = self._named(name, scope)
        if not hasattr(item, "__enter__"):
            fail(node, f"with.{name}: {name!r} is {_kind(item)}; only prims, groups and triggers can contain calls")
        with item:
            self._block(self._entries(node), scope)

    def _register(self, node: yaml.Node, scope: Scope) -> None:
        """Register each entry as `rep.randomizer.<name>`: a function of its `inputs`, its body the other entries."""
        for name, body in entries(node, "randomizer.register").items():
            block = self._entries(body)
            inputs = entries(block.pop("inputs"), "inputs") if "inputs" in block else {}
            for each, where in ((name, body), *inputs.items()):
                if not each.isidentifier():
                    fail(where, f"randomizer.register: {each!r} cannot be the name of a function or an argument")
            defaults = {key: self._value(value, scope) for key, value in inputs.items()}
            usdsdg.randomizer.register(self._function(name, defaults, block, scope), fn_name=name)

    def _function(
        self, name: str, defaults: dict[str, Any], block: dict[str, yaml.Node], scope: Scope
    ) -> Callable[..., Any]:
        def function(**given: Any) -> Any:
            self._depth += 1
            try:
                if self._depth > MAX_DEPTH:
                    raise ParserError(f"{name} and functions that it calls are more than {MAX_DEPTH} calls deep")
                return self._block(block, ChainMap({**defaults, **given}, scope))
            finally:
                self._depth -= 1

        kinds = inspect.Parameter
        function.__name__ = name
        function.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
            [kinds(key, kinds.KEYWORD_ONLY, default=value) for key, value in defaults.items()]
        )
        return function

    def _entries(self, node: yaml.Node, heirs: tuple[str, ...] = ()) -> dict[str, yaml.Node]:
        """Return the entries of a block, inherited ones included; `heirs` are the groups that inherit from it."""
        block = entries(node, "a group")
        if INHERIT not in block:
            return block
        name = str(plain(block[INHERIT]))
        if name in heirs:
            fail(block[INHERIT], f"group {name!r} inherits from itself")
        parent = self._entries(self._document.group(block.pop(INHERIT)), (*heirs, name))
        return merged(block, parent)

    # --- calls ---
    def _call(self, name: str, node: yaml.Node, scope: Scope) -> Any:
        function = self._found(name, node, scope)
        self._calls_left -= 1
        if self._calls_left < 0:
            fail(node, f"the file makes more than {MAX_CALLS} calls")
        if not isinstance(node, yaml.MappingNode) and plain(node) is not None:
            fail(node, f"{name} takes its arguments as a mapping of names to values, not {plain(node)!r}")
        given = {key: self._argument(key, value, scope) for key, value in entries(node, name).items()}
        _check(name, function, given, node)
        _refuse_code(name, given, node)
        mark = node.start_mark
        try:
            with made_at(f"{Path(mark.name).name}:{mark.line + 1}"):
                return function(**given)
        except ParserError:
            raise
        except (UsdsdgError, TypeError, ValueError, LookupError, AttributeError, RuntimeError, OSError) as error:
            fail(node, f"{name}: {error}{self._names_meant(given, scope)}", cause=error)

    def _found(self, name: str, node: yaml.Node, scope: Scope) -> Callable[..., Any]:
        """Return the function of `rep`, or the method of an earlier group's result, that a key names."""
        first, *rest = name.split(".")
        if first not in FAMILIES and first not in scope:
            fail(node, f"{name}: there is no module or group {first!r}{hint(first, [*FAMILIES, *scope])}")
        found = public_function(name)
        if found is None and first in scope:
            found = public_method(self._named(first, scope), rest)
        if found is not None:
            return found
        if first == "functional" and rest[-1].startswith(("write_", "read_")):
            fail(node, f"{name} takes files of any name, so a YAML file cannot call it; files are written by writers")
        known = public_functions(first) if first in FAMILIES else public_methods(scope[first])
        fail(node, f"there is no function {name} that a YAML file may call{hint('.'.join(rest), known)}")

    def _names_meant(self, given: dict[str, Any], scope: Scope) -> str:
        """Return a hint where a string argument looks like the name of a group, or ""."""
        for key, value in given.items():
            if isinstance(value, str) and key not in TEXT:
                if value in self._document.groups:
                    line = self._document.groups[value].start_mark.line + 1
                    return f" ({key} is {value!r}, a group that is defined later, in line {line})"
                if close := hint(value, scope):
                    return f" ({key} is {value!r}{close})"
        return ""

    # --- values ---
    def _argument(self, name: str, node: yaml.Node, scope: Scope) -> Any:
        return _tuples(plain(node)) if name in TEXT else self._value(node, scope)

    def _value(self, node: yaml.Node, scope: Scope) -> Any:
        """Evaluate a value: a call, a path, the result of a group, or a plain value; lists of numbers become tuples."""
        if isinstance(node, yaml.SequenceNode):
            return _tuples([self._value(each, scope) for each in items(node, "a list")])
        if not isinstance(node, yaml.MappingNode):
            value = plain(node)
            return self._named(value, scope) if isinstance(value, str) else value
        block = self._entries(node)
        if any("." in name for name in block):
            if len(block) > 1:
                fail(node, f"a value is one call, not {len(block)}: {', '.join(block)}")
            ((name, arguments),) = block.items()
            return self._call(name, arguments, scope)
        if block.keys() == PATH:
            return self._path(block)
        return {name: self._value(value, scope) for name, value in block.items()}

    def _named(self, name: str, scope: Scope) -> Any:
        """Return the result of the group of that name, or the string itself where there is none."""
        if name in scope:
            return scope[name]
        if name in self._document.templates:
            self._made[name] = self._group(self._document.templates[name], self._made)
            return self._made[name]
        return name

    def _path(self, block: dict[str, yaml.Node]) -> str:
        path, kind = str(plain(block["value"])), plain(block["property"])
        if kind == "file_path":
            return str((self._document.file_root / path).absolute())
        if kind != "nucleus_path":
            fail(block["property"], f"property is {kind!r}; expected file_path or nucleus_path")
        server = self._document.nucleus or "localhost"
        return f"{server if '://' in server else f'omniverse://{server}'}".rstrip("/") + "/" + path.lstrip("/")


def _check(name: str, function: Callable[..., Any], given: dict[str, Any], node: yaml.Node) -> None:
    """Report arguments that a function does not take or that are missing, with their lines."""
    try:
        parameters = inspect.signature(function).parameters
    except (TypeError, ValueError):  # written in C
        return
    kinds = inspect.Parameter
    takes = [key for key, each in parameters.items() if each.kind not in (kinds.VAR_KEYWORD, kinds.VAR_POSITIONAL)]
    if not any(each.kind is kinds.VAR_KEYWORD for each in parameters.values()):
        for key in given:
            if key not in takes:
                near = hint(key, takes) or f"; it takes {', '.join(takes) or 'none'}"
                fail(entries(node, name)[key], f"{name} got an unexpected keyword argument {key!r}{near}")
    lacking = [key for key in takes if parameters[key].default is kinds.empty and key not in given]
    if lacking:
        fail(node, f"{name} needs a value for {', '.join(lacking)}")


def _refuse_code(name: str, given: dict[str, Any], node: yaml.Node) -> None:
    """Refuse arguments with which a file would have scripts run that a stage names."""
    for value in given.values():
        if isinstance(value, str) and (lets_files_run_code(value) or value.startswith("omni:scripting:")):
            fail(node, f"{name}: {value} decides which scripts run, and a YAML file may not set it")


def _tuples(value: Any) -> Any:
    """Convert lists of numbers, such as a position or a color, to tuples."""
    if not isinstance(value, list):
        return value
    inner = [_tuples(each) for each in value]
    numbers = inner and all(isinstance(each, (int, float)) and not isinstance(each, bool) for each in inner)
    return tuple(inner) if numbers else inner


def _kind(value: Any) -> str:
    return (
        f"the {type(value).__name__} {value!r}" if isinstance(value, (str, int, float)) else f"a {type(value).__name__}"
    )
