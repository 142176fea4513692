"""Search for prims by path, type and labels: `rep.get`. Results are items for `with` and `input_prims`.

Prims are searched when the line runs, in stage order, and with `cache_result=False` again at each execution of what
acts on them; the graph's own nodes, inactive prims, classes, and what is inside of instances and cannot be edited, are
left out.
"""

from collections.abc import Callable
from typing import Any

from usdsdg.arguments.parameters import name_parameters
from usdsdg.arguments.registry import register_function
from usdsdg.errors import BadPrim, let_pass
from usdsdg.functional import get as find
from usdsdg.graph.live_prims import LivePrims, search
from usdsdg.graph.node import Node, ReplicatorItem, prim_paths
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.paths import prim_at
from usdsdg.stage.scopes import PIPELINE

_SEARCH = "get"


def prims(
    path_pattern: str | None = None, path_match: str | None = None, path_pattern_exclusion: str | None = None,
    prim_types: Any = None, prim_types_exclusion: Any = None, semantics: Any = None, semantics_exclusion: Any = None,
    cache_result: bool = True, ignore_case: bool = True, name: str | None = None,
    *, cache_prims: bool = True,
) -> ReplicatorItem:  # fmt: skip
    """Find the prims that meet all given conditions; the item is empty if there are none.

    Args:
        path_pattern: regular expression that must be found in the path; `path_pattern_exclusion` must not be found.
        path_match: substring of the path.
        prim_types: type or list of types, case-insensitive; `prim_types_exclusion` likewise.
        semantics: pairs of type and label, [("class", "cube")] or {"class": "cube"}; a prim matches if it has a label
            of that type which contains the given one, for any of the pairs; of shapes and subsets labels of their
            material count too. `semantics_exclusion` likewise.
        cache_result: False: what acts on the prims searches them again at each execution. It does nothing where there
            are none then.
        ignore_case: whether paths match case-insensitively.
        cache_prims: what `cache_result` was called in Replicator 1.4.

    Raises:
        ArgumentError: a pattern is not a regular expression, or `semantics` are not labels.
    """
    conditions = {
        "path_pattern": path_pattern, "path_match": path_match, "path_pattern_exclusion": path_pattern_exclusion,
        "prim_types": prim_types, "prim_types_exclusion": prim_types_exclusion, "semantics": semantics,
        "semantics_exclusion": semantics_exclusion, "ignore_case": ignore_case,
    }  # fmt: skip
    return _item("prims", conditions, cache_result and cache_prims, name)


def _item(function: str, conditions: dict[str, Any], cache_result: bool, name: str | None) -> ReplicatorItem:
    given = {key: value for key, value in conditions.items() if value is not None}
    part = {"kind": _SEARCH, "arguments": {"function": function, **given}}
    found = _search(function, **given) if cache_result else LivePrims([part])
    return ReplicatorItem(Node(kind="OgnGetPrims", prims=found, name=name))


@search(_SEARCH)
def _search(function: str, **conditions: Any) -> tuple[str, ...]:
    """Return the paths of what `functional.get.<function>` finds on the current stage."""
    paths = (str(prim.GetPath()) for prim in getattr(find, function)(None, **conditions))
    return tuple(path for path in paths if not path.startswith(f"{PIPELINE}/"))


def prim_at_path(path: Any, name: str | None = None) -> ReplicatorItem:
    """Return an item of the prims at a path, or of those in a list of paths, prims or items.

    Of a choice or sequence of prims it is an item of those that are drawn at each execution.

    Raises:
        BadPrim: one of them is not on the stage; the message names near misses.
    """
    wanted = prim_paths(path)
    if hasattr(path, "sample"):
        if not wanted:
            raise BadPrim(
                f"get.prim_at_path: path is {path.node.describe()}, which does not draw from prims that are on the "
                "stage. Give it their paths, or draw assets by randomizer.instantiate"
            )
        return ReplicatorItem(Node(kind="OgnGetPrimAtPath", prims=wanted, name=name))
    if not wanted:
        raise BadPrim(f"get.prim_at_path: path is {path!r}; give at least one")
    found = tuple(each for each in wanted if _is_there(each))
    return ReplicatorItem(Node(kind="OgnGetPrimAtPath", prims=found, name=name))


def _is_there(path: str) -> bool:
    """Whether there is a prim at `path`; an error, or a warning where errors are let pass, if there is none."""
    try:
        prim_at(current_stage(), path)
    except BadPrim as error:
        let_pass(error)
        return False
    return True


def _by_type(kind: str) -> Callable[..., ReplicatorItem]:
    """Return a search function like `prims` for fixed prim types."""
    finder = getattr(find, kind)

    def get(
        path_pattern: str | None = None, path_pattern_exclusion: str | None = None, semantics: Any = None,
        semantics_exclusion: Any = None, cache_result: bool = True, name: str | None = None,
        path_match: str | None = None,
    ) -> ReplicatorItem:  # fmt: skip
        conditions = {
            "path_pattern": path_pattern, "path_pattern_exclusion": path_pattern_exclusion, "semantics": semantics,
            "semantics_exclusion": semantics_exclusion, "path_match": path_match, "ignore_case": True,
        }  # fmt: skip
        return _item(kind, conditions, cache_result, name)

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
        ValueError: the name is not an identifier, or taken while `override` is False.
    """
    register_function(globals(), "get", func, override, fn_name)


name_parameters(globals())
