"""What a writer's `write` counts, read from its source: such writers need no `skip` of their own."""

from __future__ import annotations

import ast
import functools
import inspect
import textwrap
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from usdsdg.errors import Unsupported

# Methods of containers that change them.
_CHANGING = {
    "add", "append", "appendleft", "clear", "discard", "extend", "insert", "pop", "popitem", "popleft", "remove",
    "setdefault", "update", "write",
}  # fmt: skip


def advance(writer: Any) -> None:
    """Advance the counters of a writer as `write` would.

    Raises:
        Unsupported: `write` keeps more from frame to frame than counters, so frames cannot be left out.
    """
    for name, step in counters(type(writer)).items():
        setattr(writer, name, getattr(writer, name) + step)


@contextmanager
def counted(writer: Any) -> Iterator[None]:
    """Count the frame that a `write` in the context writes, also if it fails: a part of its files may be written.

    Other writers have the frame under the same number. Counters that the `write` did not come to are advanced; of a
    writer that keeps more than counters it is `_frame_id`, as Replicator's writers name it.
    """
    before = dict(vars(writer))
    try:
        yield
    except BaseException:
        _advance(writer, before)
        raise
    finally:
        writer.num_written += 1


def count(writer: Any) -> None:
    """Count a frame that a writer misses."""
    _advance(writer, vars(writer))
    writer.num_written += 1


def _advance(writer: Any, before: Mapping[str, Any]) -> None:
    """Advance a writer's counters by one frame that have the values of `before`, by their names."""
    for name, step in _steps(type(writer)).items():
        value = vars(writer).get(name)
        if isinstance(value, int) and value == before.get(name):
            setattr(writer, name, value + step)


def _steps(kind: type) -> Mapping[str, int]:
    try:
        return counters(kind)
    except Unsupported:
        return {"_frame_id": 1}


@functools.lru_cache(maxsize=256)
def counters(kind: type) -> Mapping[str, int]:
    """Return by how much `write` advances each attribute of a writer.

    Raises:
        Unsupported: as `advance`.
    """
    found: dict[str, int] = {}
    problems: list[str] = []
    for function in _reached(kind, "write"):
        own = {id(each) for each in function.body}
        for node in ast.walk(function):
            if isinstance(node, ast.AugAssign) and (name := _attribute(node.target)):
                step = _step(node)
                if step is None or id(node) not in own or function.name != "write":
                    problems.append(f"self.{name} in line {node.lineno} of {function.name}")
                else:
                    found[name] = found.get(name, 0) + step
            elif isinstance(node, (ast.Assign, ast.AnnAssign)):
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                for name in filter(None, map(_attribute_or_item, targets)):
                    problems.append(f"self.{name} in line {node.lineno} of {function.name}")
            elif (called := _changed(node)) is not None:
                problems.append(f"self.{called}() in line {node.lineno} of {function.name}")
    if problems:
        raise Unsupported(
            f"{kind.__name__} keeps more than counters from frame to frame ({'; '.join(problems)}), so it cannot leave "
            "out frames that are made already or elsewhere. Give it a method `skip(self, data)`, which does for such a "
            "frame what `write` does to the writer's own attributes; `data` has no arrays."
        )
    return found


def _reached(kind: type, name: str, seen: set[str] | None = None) -> Iterator[ast.FunctionDef]:
    """Yield the method of that name and those of the same object that it calls."""
    seen = set() if seen is None else seen
    method = getattr(kind, name, None)
    if name in seen or not inspect.isfunction(method) or method.__module__ == "usdsdg.writers.base":
        return
    seen.add(name)
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(method)))
    except (OSError, TypeError, SyntaxError):
        raise Unsupported(
            f"the source of {kind.__name__}.{name} cannot be read, so it is not known what it keeps from frame to "
            "frame. Give the writer a method `skip(self, data)`."
        ) from None
    function = tree.body[0]
    assert isinstance(function, ast.FunctionDef)
    yield function
    for node in ast.walk(function):
        if isinstance(node, ast.Call) and (called := _attribute(node.func)):
            yield from _reached(kind, called, seen)


def _attribute(node: ast.AST) -> str | None:
    """Return the name of an attribute of `self`."""
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "self":
        return node.attr
    return None


def _attribute_or_item(node: ast.AST) -> str | None:
    """Return the name of an attribute of `self`, also where the node is an item or a part of it."""
    while isinstance(node, (ast.Subscript, ast.Attribute)):
        if (name := _attribute(node)) is not None:
            return name
        node = node.value
    return None


def _changed(node: ast.AST) -> str | None:
    """Return the call of a method that changes a container of `self`, such as "names.append"."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in _CHANGING:
        name = _attribute_or_item(node.func.value)
        return None if name in (None, "backend", "_backend") else f"{name}.{node.func.attr}"
    return None


def _step(node: ast.AugAssign) -> int | None:
    """Return by how much a statement advances a counter; None if it is no number."""
    value = node.value.value if isinstance(node.value, ast.Constant) else None
    if not isinstance(value, int) or not isinstance(node.op, (ast.Add, ast.Sub)):
        return None
    return value if isinstance(node.op, ast.Add) else -value
