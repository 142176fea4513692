"""What a writer's `write` counts, read from its source: such writers need no `skip` of their own."""

from __future__ import annotations

import ast
import functools
import inspect
import json
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Set
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from usdsdg.errors import Unsupported, WriterError

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
    _add(writer, counters(type(writer)))


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
    changes = _changes(_reached(kind, "write"))
    if changes.others:
        raise Unsupported(
            f"{kind.__name__} keeps more than counters from frame to frame ({changes.named()}), so it cannot leave "
            "out frames that are made already or elsewhere. Give it a method `skip(self, data)`, which does for such a "
            "frame what `write` does to the writer's own attributes; `data` has no arrays."
        )
    return changes.steps


def advance_own(writer: Any) -> None:
    """Advance the counters of a `write` that overrides one with a `skip`, which does not know of them.

    Raises:
        Unsupported: the `write` keeps more than counters from frame to frame.
    """
    _add(writer, _own(type(writer)))


def advance_unkept(writer: Any) -> None:
    """Advance the counters of a script's own `write` that the writer's `kept` leaves out.

    Raises:
        Unsupported: the `write` keeps more than counters, which are not in `kept`.
    """
    _add(writer, _unkept(type(writer), tuple(writer.kept)))


def kept_of(writer: Any) -> dict[str, Any]:
    """Return what a writer's `kept` names, as it is now: the journal is written later.

    Raises:
        WriterError: there is no such attribute, or its value is not JSON.
    """
    found = {}
    for name in writer.kept:
        if not hasattr(writer, name):
            raise WriterError(f"{type(writer).__name__} has no attribute {name!r}, which its `kept` names.")
        value = getattr(writer, name)
        try:
            found[name] = json.loads(json.dumps(value, default=_number))
        except (TypeError, ValueError) as error:
            raise WriterError(
                f"{type(writer).__name__}: `kept` names {name}, a {type(value).__name__}, and the journal takes JSON "
                f"values only ({error}). Keep numbers, texts, lists or dictionaries of them."
            ) from None
    return found


def _number(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"a {type(value).__name__} is none")


def restore(writer: Any, kept: Mapping[str, Any]) -> None:
    """Give a writer what the journal has of `kept`, if it has anything.

    Raises:
        Unsupported: attributes are named there now that were not when the frames were made.
    """
    if kept and (missing := [name for name in writer.kept if name not in kept]):
        raise Unsupported(
            f"{type(writer).__name__} cannot resume these frames: `kept` names {', '.join(missing)}, of which the "
            "journal has no value, since it did not name it when the frames were made. Make the dataset again."
        )
    for name, value in kept.items():
        setattr(writer, name, value)


def _add(writer: Any, steps: Mapping[str, int]) -> None:
    for name, step in steps.items():
        setattr(writer, name, getattr(writer, name) + step)


@functools.lru_cache(maxsize=256)
def _own(kind: type) -> Mapping[str, int]:
    owner = _owner(kind, "skip")
    if _is_base(owner):
        return {}  # it has read the source of the whole `write`
    skipped = _changes(_reached(kind, "skip"))
    below = kind.__mro__[: kind.__mro__.index(owner)]
    changes = _changes(each for each in _reached(kind, "write") if each.owner in below).without(
        {*skipped.steps, *(name for name, _ in skipped.others)}
    )
    if changes.others:
        raise Unsupported(
            f"{kind.__name__} keeps more than counters from frame to frame ({changes.named()}), of which the `skip` of "
            f"{owner.__name__} does not know, so it cannot leave out frames that are made already or elsewhere. Give "
            "it a method `skip(self, data)`, which calls that of its base, and does for such a frame what `write` "
            "does to the writer's own attributes; `data` has no arrays."
        )
    return changes.steps


@functools.lru_cache(maxsize=256)
def _unkept(kind: type, kept: tuple[str, ...]) -> Mapping[str, int]:
    changes = _changes(each for each in _reached(kind, "write") if not _is_of_project(each.owner)).without(set(kept))
    if changes.others:
        raise Unsupported(
            f"{kind.__name__} keeps more than counters from frame to frame ({changes.named()}) that its `kept` does "
            "not name, so it cannot go on after frames that were made before: files of these might be replaced. Name "
            "them there too, as JSON values, and make the dataset again."
        )
    return changes.steps


def _is_of_project(owner: type) -> bool:
    return owner.__module__.partition(".")[0] == "usdsdg"


def _is_base(owner: type) -> bool:
    return owner.__module__ == "usdsdg.writers.base"


@dataclass
class _Changes:
    """What methods do to attributes of `self`: steps of counters, and (name, where) of all else."""

    steps: dict[str, int] = field(default_factory=dict)
    others: list[tuple[str, str]] = field(default_factory=list)

    def without(self, names: Set[str]) -> _Changes:
        """The same without some attributes."""
        steps = {name: step for name, step in self.steps.items() if name not in names}
        return _Changes(steps, [each for each in self.others if each[0] not in names])

    def named(self) -> str:
        return "; ".join(where for _, where in self.others)


def _changes(methods: Iterable[_Method]) -> _Changes:
    found, others = {}, []
    for method in methods:
        function = method.tree
        own = {id(each) for each in _always_run(function)} if method.is_always_run else set()
        for node in ast.walk(function):
            where = f"in line {getattr(node, 'lineno', 0)} of {function.name}"
            if isinstance(node, ast.AugAssign) and (name := _attribute_or_item(node.target)):
                step = _step(node) if _attribute(node.target) else None
                if step is None or id(node) not in own:
                    others.append((name, f"self.{name} {where}"))
                else:
                    found[name] = found.get(name, 0) + step
            elif isinstance(node, (ast.Assign, ast.AnnAssign)):
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                for name in filter(None, map(_attribute_or_item, _single(targets))):
                    others.append((name, f"self.{name} {where}"))
            elif (called := _changed(node)) is not None:
                others.append((called.partition(".")[0], f"self.{called}() {where}"))
    return _Changes(found, others)


def _single(targets: Iterable[ast.expr]) -> Iterator[ast.expr]:
    """Yield what is assigned to, also within tuples."""
    for each in targets:
        if isinstance(each, (ast.Tuple, ast.List)):
            yield from _single(each.elts)
        else:
            yield each.value if isinstance(each, ast.Starred) else each


@dataclass(frozen=True)
class _Method:
    """A method that a frame runs: the class that defines it, its text, and whether each of its statements is run."""

    owner: type
    tree: ast.FunctionDef
    is_always_run: bool


def _owner(kind: type, name: str, after: type | None = None) -> type:
    """Return the class that defines a method, among those after another in the order in which they are looked up."""
    order = kind.__mro__ if after is None else kind.__mro__[kind.__mro__.index(after) + 1 :]
    return next((each for each in order if name in vars(each)), object)


def _reached(
    kind: type, name: str, after: type | None = None, seen: set[tuple[type, str]] | None = None, *, always: bool = True
) -> Iterator[_Method]:
    """Yield the method of that name and those of the same object that it calls, also by `super()`.

    after: the class whose method calls it by `super()`. always: whether it is run at each frame, once.
    """
    seen = set() if seen is None else seen
    owner = _owner(kind, name, after)
    method = vars(owner).get(name)
    if (owner, name) in seen or not inspect.isfunction(method) or _is_base(owner):
        return
    seen.add((owner, name))
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(method)))
    except (OSError, TypeError, SyntaxError):
        raise Unsupported(
            f"the source of {kind.__name__}.{name} cannot be read, so it is not known what it keeps from frame to "
            "frame. Give the writer a method `skip(self, data)`."
        ) from None
    function = tree.body[0]
    assert isinstance(function, ast.FunctionDef)
    yield _Method(owner, function, always)
    calls = [node for node in ast.walk(function) if isinstance(node, ast.Call)]
    of_super = [called for node in calls if (called := _called_of_super(node.func))]
    own = [each for each in _always_run(function) if isinstance(each, (ast.Expr, ast.Return, ast.Assign))]
    once = {id(each.value) for each in own} if always and of_super.count(name) == 1 else set()
    for node in calls:
        if called := _attribute(node.func):
            yield from _reached(kind, called, None, seen, always=False)
        elif called := _called_of_super(node.func):
            yield from _reached(kind, called, owner, seen, always=called == name and id(node) in once)


def _always_run(function: ast.FunctionDef) -> Iterator[ast.stmt]:
    """Yield the statements of a function up to the first one that may return."""
    for statement in function.body:
        yield statement
        inner: list[ast.AST] = [statement]
        while inner:
            node = inner.pop()
            if isinstance(node, ast.Return):
                return
            if not isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.Lambda)):
                inner += ast.iter_child_nodes(node)


def _called_of_super(node: ast.AST) -> str | None:
    """Return the name of a method in `super().method`."""
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Call):
        function = node.value.func
        return node.attr if isinstance(function, ast.Name) and function.id == "super" else None
    return None


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
