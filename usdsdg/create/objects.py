"""Object prims: an Xform `/Replicator/<Type>_Xform[_NN]` with pose and labels, and one child `<Type>`."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from pxr import Sdf, Usd

from usdsdg import modify
from usdsdg.arguments.prim_names import prim_name
from usdsdg.arguments.values import count_of, vector
from usdsdg.errors import warn_once
from usdsdg.graph.node import Node, ReplicatorItem, prim_paths, rep_function
from usdsdg.session.stage_context import current_stage
from usdsdg.stage import paths
from usdsdg.stage.poses.first_ops import author_first_pose
from usdsdg.stage.prims.copies import copy_prim
from usdsdg.stage.scopes import REPLICATOR, define_scope


def create_objects(
    kind: str, define: Callable[[Usd.Stage, str], object] | None, *, node: str, name: str | None, parent: Any,
    count: Any, **arguments: Any,
) -> ReplicatorItem:  # fmt: skip
    """Create object Xforms with the common arguments, and the child that `define` makes at a path of a stage.

    The first is copied, in one change: one by one, each would take as long as its parent has children. Without `define`
    the Xforms have no child and are called `<name>[_NN]`.

    Args:
        node: kind of the graph's node.

    Raises:
        ArgumentError: `count` is not an integer, or negative. BadPrim: as for `new_object`.
    """
    _warn_of_two_directions(arguments.get("rotation"), arguments.get("look_at"))
    if not (number := count_of(count)):
        return apply_common_arguments([], kind=node, name=name, **arguments)
    pose, others = _one_pose_for_all(arguments)
    if define is None:
        first = str(new_xform(name or kind, parent, pose).GetPath())
    else:
        first, child = new_object(kind, name, parent, pose)
        define(current_stage(), child)
    return apply_common_arguments([first, *copies_of(first, number - 1)], kind=node, name=name, **others)


def _warn_of_two_directions(rotation: Any, look_at: Any) -> None:
    if rotation is not None and look_at is not None:
        warn_once(f"{rep_function()}: rotation and look_at exclude each other, and only one of them counts; give that")


def _one_pose_for_all(arguments: dict[str, Any]) -> tuple[dict[str, list[float]], dict[str, Any]]:
    """Take position, rotation and scale that are constants for all objects out of common arguments: copies have them.

    With a pivot, positions and rotations refer to the geometry, which is not there yet.
    """
    ops = {"position": "translate", "rotation": "rotateXYZ", "scale": "scale"}
    taken = {
        role: vector(role, value)
        for role in ops
        if arguments.get("pivot") is None and _is_one_vector(value := arguments.get(role))
    }
    others = {role: value for role, value in arguments.items() if role not in taken}
    return {ops[role]: value for role, value in taken.items()}, others


def _is_one_vector(value: Any) -> bool:
    """Whether a value is one number, or a tuple or list of three."""
    numbers = value if isinstance(value, (tuple, list)) and len(value) == 3 else [value]
    return all(isinstance(each, (int, float)) for each in numbers)


def copies_of(path: str, count: int) -> list[str]:
    """Copy a new object of the edit target's layer; return the paths of the copies."""
    stage = current_stage()
    target, copies = stage.GetEditTarget(), paths.free_paths(stage, path, count)
    copy_prim(stage, target.GetLayer(), target.MapToSpecPath(Sdf.Path(path)), copies)
    return copies


def new_object(
    kind: str, name: str | None, parent: Any, pose: Mapping[str, Sequence[float]] | None = None
) -> tuple[str, str]:
    """Create an object Xform; return its path and that for its child.

    Raises:
        BadPrim: `parent` is not on the stage, or is a shape.
    """
    label = prim_name(name) if name else kind
    path = str(new_xform(f"{label}_Xform", parent, pose).GetPath())
    return path, f"{path}/{label}"


def new_xform(name: str, parent: Any, pose: Mapping[str, Sequence[float]] | None = None) -> Usd.Prim:
    """Create the Xform `<parent>/<name>[_NN]` of an object, by default below `/Replicator`.

    Args:
        pose: values of translate, rotateXYZ and scale; of those that are not given identities.

    Raises:
        BadPrim: `parent` is not on the stage, or is a shape.
    """
    stage = current_stage()
    root = prim_paths(parent)[0] if parent is not None else REPLICATOR
    if parent is None:
        define_scope(stage, REPLICATOR)
    paths.check_parent(paths.prim_at(stage, root))
    path, target = paths.next_free_path(stage, f"{root}/{prim_name(name)}"), stage.GetEditTarget()
    with Sdf.ChangeBlock():
        spec = Sdf.CreatePrimInLayer(target.GetLayer(), target.MapToSpecPath(Sdf.Path(path)))
        spec.specifier, spec.typeName = Sdf.SpecifierDef, "Xform"
        Sdf.AttributeSpec(spec, "replicatorXform", Sdf.ValueTypeNames.Bool).default = True
        author_first_pose(spec, pose or {})
    return stage.GetPrimAtPath(path)


def apply_common_arguments(
    objects: Sequence[str],
    *,
    position: Any = None,
    rotation: Any = None,
    scale: Any = None,
    look_at: Any = None,
    look_at_up_axis: Any = None,
    pivot: Any = None,
    semantics: Any = None,
    visible: Any = True,
    kind: str,
    name: str | None = None,
) -> ReplicatorItem:
    """Write pose, labels and visibility of the objects at some paths, or schedule what is a distribution."""
    _warn_of_two_directions(rotation, look_at)
    item = ReplicatorItem(Node(kind=kind, prims=tuple(objects), name=name))
    modify.apply_or_schedule_pose(
        item, position=position, pivot=pivot, rotation=rotation, scale=scale, look_at=look_at,
        look_at_up_axis=look_at_up_axis,
    )  # fmt: skip
    if semantics is not None:
        modify.semantics(semantics, input_prims=item)
    if visible is not True:
        modify.visibility(visible, input_prims=item)
    return item
