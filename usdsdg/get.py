"""Prims of the stage by path, type and labels, as items for `with` and `input_prims`. Mirrors `rep.get`.

Prims are found when the line runs, in the order of the stage; the graph's own nodes and prims inside instances, which
cannot be edited, are left out.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pxr import Usd

from usdsdg.arguments.registry import register_function
from usdsdg.errors import BadPrim, warn_once
from usdsdg.functional import get as find
from usdsdg.graph.node import Node, ReplicatorItem, prim_paths
from usdsdg.graph.node_prims import PIPELINE
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.paths import prim_at


def prims(
    path_pattern: str | None = None, path_match: str | None = None, path_pattern_exclusion: str | None = None,
    prim_types: Any = None, prim_types_exclusion: Any = None, semantics: Any = None, semantics_exclusion: Any = None,
    cache_result: bool = True, ignore_case: bool = True, name: str | None = None,
) -> ReplicatorItem:  # fmt: skip
    """The prims that meet every condition given; none is an empty item.

    Args:
        path_pattern: regular expression that is searched in the path; `path_pattern_exclusion` must not be found.
        path_match: text that the path contains.
        prim_types: type or list of types, whatever the case; `prim_types_exclusion` likewise.
        semantics: pairs of type and label, [("class", "cube")] or {"class": "cube"}; a prim is taken when any of them
            is its own, the label as part of a label. `semantics_exclusion` likewise.
        cache_result: False (find them again at every execution) is not available: it warns, and they are found once.
        ignore_case: paths match in any case.

    Raises:
        ArgumentError: a pattern is no regular expression, or `semantics` are no labels.
    """
    found = find.prims(
        None, path_pattern, path_match, path_pattern_exclusion, prim_types, prim_types_exclusion, semantics,
        semantics_exclusion, ignore_case=ignore_case,
    )  # fmt: skip
    return _item("OgnGetPrims", found, cache_result, name)


def _item(kind: str, found: list[Usd.Prim], cache_result: bool, name: str | None) -> ReplicatorItem:
    if not cache_result:
        warn_once(
            "get: cache_result=False is ignored; prims are found once, when the line runs. Create them before it."
        )
    return ReplicatorItem(
        Node(kind=kind, prims=tuple(str(prim.GetPath()) for prim in found if _counts(prim)), name=name)
    )


def _counts(prim: Usd.Prim) -> bool:
    """Nodes are attached to prims, and graphs are asked for by type only."""
    return not prim.IsInstanceProxy() and not prim.GetPath().pathString.startswith(f"{PIPELINE}/")


def prim_at_path(path: Any, name: str | None = None) -> ReplicatorItem:
    """The prims at a path, or at those of a list, of prims or of another item.

    Raises:
        BadPrim: one of them is not on the stage; names near misses.
    """
    wanted = prim_paths(path)
    if not wanted:
        raise BadPrim(f"get.prim_at_path: path is {path!r}; give at least one")
    for each in wanted:
        prim_at(current_stage(), each)
    return ReplicatorItem(Node(kind="OgnGetPrimAtPath", prims=wanted, name=name))


def _by_type(kind: str) -> Callable[..., ReplicatorItem]:
    """A function like `prims` that knows the types."""
    finder = getattr(find, kind)

    def get(
        path_pattern: str | None = None, path_pattern_exclusion: str | None = None, semantics: Any = None,
        semantics_exclusion: Any = None, cache_result: bool = True, name: str | None = None,
        path_match: str | None = None,
    ) -> ReplicatorItem:  # fmt: skip
        found = finder(
            None, path_pattern, path_pattern_exclusion, semantics, semantics_exclusion, path_match=path_match,
            ignore_case=True,
        )  # fmt: skip
        return _item("OgnGetPrims", found, cache_result, name)

    get.__name__ = get.__qualname__ = kind
    get.__doc__ = f"{finder.__doc__.partition(';')[0]}; see `prims` for the arguments."
    return get


camera = _by_type("camera")
curve = _by_type("curve")
geomsubset = _by_type("geomsubset")
graph = _by_type("graph")
light = _by_type("light")
listener = _by_type("listener")
material = _by_type("material")
mesh = _by_type("mesh")
physics = _by_type("physics")
renderproduct = _by_type("renderproduct")
rendervar = _by_type("rendervar")
scope = _by_type("scope")
shader = _by_type("shader")
shape = _by_type("shape")
skelanimation = _by_type("skelanimation")
skeleton = _by_type("skeleton")
sound = _by_type("sound")
xform = _by_type("xform")


def register(func: Callable[..., Any], override: bool = True, fn_name: str | None = None) -> None:
    """Make `rep.get.<name>` call `func`.

    Raises:
        ValueError: the name is no identifier, or taken while `override` is False.
    """
    register_function(globals(), "get", func, override, fn_name)
