"""Commands that create, delete, move, copy and select prims."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from pxr import Sdf, Usd, UsdGeom

from usdsdg.compat import prim_moves
from usdsdg.compat.omni.kit.commands.registry import command
from usdsdg.compat.omni.kit.commands.transforms import set_world_matrix, teleport_prim
from usdsdg.errors import ArgumentError, BadPrim, Unsupported
from usdsdg.functional import create
from usdsdg.session.session import current
from usdsdg.session.stage_context import current_stage
from usdsdg.stage import assets
from usdsdg.stage.paths import next_free_path

AnyPath = str | Sdf.Path

# Meshes of the mesh commands, and who makes them.
_MESHES = {
    "Cone": create.cone, "Cube": create.cube, "Cylinder": create.cylinder, "Disk": create.disk, "Plane": create.plane,
    "Sphere": create.sphere, "Torus": create.torus,
}  # fmt: skip


@command("CreatePrim")
def create_prim(
    prim_type: str,
    prim_path: AnyPath | None = None,
    attributes: Mapping[str, Any] | None = None,
    create_default_xform: bool = False,
    select_new_prim: bool = True,
    stage: Usd.Stage | None = None,
) -> str:
    """Define a prim, below the default prim where no path is given; return its path. A number makes the path free."""
    target = stage or current_stage()
    path = _free_path(target, prim_path, prim_type)
    prim = target.DefinePrim(path, prim_type)
    if create_default_xform and prim.IsA(UsdGeom.Xformable):
        _add_default_ops(prim)
    for name, value in (attributes or {}).items():
        attribute = prim.GetAttribute(name)
        if not attribute:
            raise BadPrim(f"CreatePrim {path}: a {prim_type} has no attribute {name!r}")
        attribute.Set(value)
    _select(path, select_new_prim)
    return path


@command("CreatePrimWithDefaultXform")
def create_prim_with_default_xform(
    prim_type: str,
    prim_path: AnyPath | None = None,
    attributes: Mapping[str, Any] | None = None,
    select_new_prim: bool = True,
    stage: Usd.Stage | None = None,
) -> str:
    """Define a prim with translate, rotate and scale ops; return its path."""
    return create_prim(prim_type, prim_path, attributes, True, select_new_prim, stage)


@command("CreateMeshPrim")
@command("CreateMeshPrimWithDefaultXform")
def create_mesh_prim(
    prim_type: str, prim_path: AnyPath | None = None, select_new_prim: bool = True, above_ground: bool = False
) -> str:
    """Create a mesh of one meter, with translate, rotate and scale ops; return its path.

    Raises:
        ArgumentError: there is no mesh of this type.
    """
    if prim_type not in _MESHES:
        raise ArgumentError(f"CreateMeshPrim: there is no mesh {prim_type!r}; there are {', '.join(_MESHES)}")
    stage = current_stage()
    path = Sdf.Path(_free_path(stage, prim_path, prim_type))
    parent = path.GetParentPath()
    if parent != Sdf.Path.absoluteRootPath and not stage.GetPrimAtPath(parent):
        UsdGeom.Xform.Define(stage, parent)
    below_shape = stage.GetPrimAtPath(parent).IsA(UsdGeom.Boundable)
    within = None if below_shape or parent == Sdf.Path.absoluteRootPath else str(parent)
    made = _MESHES[prim_type](name=path.name, parent=within)
    if below_shape:  # the application nests shapes, which `create` refuses
        prim_moves.move(stage, made.GetPath(), path)
        made = stage.GetPrimAtPath(path)
    _select(str(made.GetPath()), select_new_prim)
    return str(made.GetPath())


@command("CreateReference")
@command("AddReference")
def create_reference(
    path_to: AnyPath | None = None,
    asset_path: str | None = None,
    prim_path: AnyPath | None = None,
    instanceable: bool = False,
    select_prim: bool = True,
    stage: Usd.Stage | None = None,
    reference: Sdf.Reference | None = None,
) -> str:
    """Reference a file on the prim at `path_to` (or `prim_path` with a `reference`), defined if there is none."""
    return _compose(path_to, asset_path, prim_path, instanceable, select_prim, stage, reference, "references")


@command("CreatePayload")
@command("AddPayload")
def create_payload(
    path_to: AnyPath | None = None,
    asset_path: str | None = None,
    prim_path: AnyPath | None = None,
    instanceable: bool = False,
    select_prim: bool = True,
    stage: Usd.Stage | None = None,
    payload: Sdf.Payload | None = None,
) -> str:
    """Add a file as payload of the prim at `path_to` (or `prim_path` with a `payload`), defined if there is none."""
    return _compose(path_to, asset_path, prim_path, instanceable, select_prim, stage, payload, "payloads")


def _compose(
    path_to: AnyPath | None,
    asset_path: str | None,
    prim_path: AnyPath | None,
    instanceable: bool,
    select_prim: bool,
    stage: Usd.Stage | None,
    arc: Sdf.Reference | Sdf.Payload | None,
    kind: str,
) -> str:
    target = stage or current_stage()
    # With an arc, `prim_path` is the prim that gets it; without, it is the prim of the file.
    at = path_to if path_to is not None else prim_path
    file, inner = (asset_path, prim_path) if arc is None else (arc.assetPath, arc.primPath)
    if at is None or not file:
        raise ArgumentError("CreateReference: give path_to and asset_path")
    path = Sdf.Path(str(at))
    source = assets.resolve_reference(file, str(path))
    prim = target.GetPrimAtPath(path) or target.DefinePrim(path, "Xform")
    targets = prim.GetReferences() if kind == "references" else prim.GetPayloads()
    add = targets.AddReference if kind == "references" else targets.AddPayload
    add(source, Sdf.Path(str(inner))) if inner and str(inner) != "." else add(source)
    if instanceable:
        prim.SetInstanceable(True)
    _select(str(path), select_prim)
    return str(path)


@command("IsaacSimSpawnPrim")
def spawn_prim(
    usd_path: str,
    prim_path: AnyPath,
    translation: Sequence[float] | None = (0.0, 0.0, 0.0),
    rotation: Sequence[float] | None = (0.0, 0.0, 0.0, 1.0),
) -> None:
    """Reference a file on a new prim and place it; the rotation is a quaternion (x, y, z, w).

    Where one of both is None, the prim stays where the file has it.
    """
    create_reference(prim_path, usd_path, select_prim=False)
    teleport_prim(prim_path, translation, rotation)


@command("DeletePrims")
def delete_prims(paths: Sequence[AnyPath], destructive: bool = False, stage: Usd.Stage | None = None) -> None:
    """Remove prims with all below them; those that come from a reference are deactivated, as in Kit."""
    target = stage or current_stage()
    for path in [Sdf.Path(str(each)) for each in paths]:
        prim = target.GetPrimAtPath(path)
        if not prim:
            continue
        target.RemovePrim(path)
        left = target.GetPrimAtPath(path)
        if left and left.IsDefined():
            left.SetActive(False)
    selection = current().selection
    selection.set_selected_prim_paths(
        [each for each in selection.get_selected_prim_paths() if target.GetPrimAtPath(each)]
    )


@command("IsaacSimDestroyPrim")
def destroy_prim(prim_path: AnyPath) -> None:
    """Remove a prim with all below it."""
    delete_prims([prim_path])


@command("MovePrim")
def move_prim(
    path_from: AnyPath,
    path_to: AnyPath,
    time_code: Usd.TimeCode = Usd.TimeCode.Default(),  # noqa: B008
    keep_world_transform: bool = True,
    destructive: bool = False,
    stage_or_context: Any = None,
    on_move_fn: Callable[[Sdf.Path, Sdf.Path], Any] | None = None,
) -> str:
    """Move or rename a prim, in place in the world if `keep_world_transform`; return its path.

    `on_move_fn` is called with the old and the new path.
    """
    stage = stage_or_context if isinstance(stage_or_context, Usd.Stage) else current_stage()
    source, target = _existing(stage, "MovePrim", path_from), Sdf.Path(str(path_to))
    matrix = (
        UsdGeom.Xformable(source).ComputeLocalToWorldTransform(time_code) if source.IsA(UsdGeom.Xformable) else None
    )
    parent = source.GetPath().GetParentPath()
    if not stage.GetPrimAtPath(target.GetParentPath()):
        stage.DefinePrim(target.GetParentPath(), "Xform")
    if not prim_moves.move(stage, source.GetPath(), target):
        raise Unsupported(
            f"MovePrim: {path_from} cannot become {path_to}, since it comes from another file, or that path is taken; "
            "reference the file at the new path instead"
        )
    if matrix is not None and keep_world_transform and parent != target.GetParentPath():
        set_world_matrix(stage.GetPrimAtPath(target), matrix)
    selection, moved = current().selection, Sdf.Path(str(path_from))
    selection.set_selected_prim_paths(
        [str(Sdf.Path(each).ReplacePrefix(moved, target)) for each in selection.get_selected_prim_paths()]
    )
    if on_move_fn is not None:
        on_move_fn(moved, target)
    return str(target)


@command("MovePrims")
def move_prims(
    paths_to_move: Mapping[AnyPath, AnyPath],
    keep_world_transform: bool = True,
    destructive: bool = False,
    stage_or_context: Any = None,
    on_move_fn: Callable[[Sdf.Path, Sdf.Path], Any] | None = None,
) -> None:
    """Move or rename prims, each from a key to its value."""
    how: dict[str, Any] = {"keep_world_transform": keep_world_transform, "stage_or_context": stage_or_context}
    for path_from, path_to in paths_to_move.items():
        move_prim(path_from, path_to, **how, on_move_fn=on_move_fn)


@command("ParentPrims")
def parent_prims(parent_path: AnyPath, child_paths: Sequence[AnyPath], keep_world_transform: bool = True) -> None:
    """Move prims below another."""
    for child in child_paths:
        name = Sdf.Path(str(child)).name
        move_prim(child, f"{parent_path}/{name}", keep_world_transform=keep_world_transform)


@command("UnparentPrims")
def unparent_prims(paths: Sequence[AnyPath], keep_world_transform: bool = True) -> None:
    """Move prims to the top of the stage."""
    for path in map(Sdf.Path, map(str, paths)):
        if not path.IsRootPrimPath():
            free = next_free_path(current_stage(), f"/{path.name}")
            move_prim(path, free, keep_world_transform=keep_world_transform)


@command("CopyPrim")
def copy_prim(
    path_from: AnyPath,
    path_to: AnyPath | None = None,
    duplicate_layers: bool = False,
    combine_layers: bool = False,
    exclusive_select: bool = True,
    copy_to_introducing_layer: bool = False,
) -> str:
    """Copy what the stage's edited layer holds of a prim, beside it where no path is given; return the copy's path."""
    stage = current_stage()
    source = _existing(stage, "CopyPrim", path_from).GetPath()
    target = Sdf.Path(next_free_path(stage, str(path_to or source)))
    layer = stage.GetEditTarget().GetLayer()
    if not layer.GetPrimAtPath(source):
        raise Unsupported(f"CopyPrim: {source} comes from another layer than {layer.identifier}; reference it instead")
    Sdf.CreatePrimInLayer(
        layer, target.GetParentPath()
    ) if target.GetParentPath() != Sdf.Path.absoluteRootPath else None
    Sdf.CopySpec(layer, source, layer, target)
    _select(str(target), exclusive_select)
    return str(target)


@command("CopyPrims")
def copy_prims(paths_from: Sequence[AnyPath], paths_to: Sequence[AnyPath] | None = None) -> list[str]:
    """Copy prims; return the paths of the copies."""
    targets = paths_to or [None] * len(paths_from)
    return [copy_prim(path_from, path_to) for path_from, path_to in zip(paths_from, targets)]


@command("GroupPrims")
def group_prims(prim_paths: Sequence[AnyPath]) -> str:
    """Move prims below a new Xform beside the first; return its path."""
    stage = current_stage()
    parent = Sdf.Path(str(prim_paths[0])).GetParentPath()
    group = next_free_path(stage, str(parent.AppendChild("Group")))
    UsdGeom.Xform.Define(stage, group)
    parent_prims(group, prim_paths)
    return group


@command("SelectPrims")
def select_prims(new_selected_paths: Sequence[AnyPath], old_selected_paths: Sequence[AnyPath] = ()) -> None:
    """Select prims and no others."""
    current().selection.set_selected_prim_paths(new_selected_paths)


@command("ToggleVisibilitySelectedPrims")
def toggle_visibility(selected_paths: Sequence[AnyPath], stage: Usd.Stage | None = None) -> None:
    """Show prims that are hidden and hide those that are shown."""
    for path in selected_paths:
        prim = UsdGeom.Imageable(_existing(stage or current_stage(), "ToggleVisibilitySelectedPrims", path))
        hidden = prim.GetVisibilityAttr().Get() == UsdGeom.Tokens.invisible
        prim.MakeVisible() if hidden else prim.MakeInvisible()


def _existing(stage: Usd.Stage, caller: str, path: AnyPath) -> Usd.Prim:
    prim = stage.GetPrimAtPath(str(path))
    if not prim:
        raise BadPrim(f"{caller}: {path} is not on the stage")
    return prim


def _free_path(stage: Usd.Stage, path: AnyPath | None, name: str) -> str:
    return next_free_path(stage, str(path or f"/{name}"), prepend_default_prim=path is None)


def _add_default_ops(prim: Usd.Prim) -> None:
    xformable = UsdGeom.Xformable(prim)
    if not xformable.GetOrderedXformOps():
        xformable.AddTranslateOp().Set((0.0, 0.0, 0.0))
        xformable.AddRotateXYZOp(UsdGeom.XformOp.PrecisionDouble).Set((0.0, 0.0, 0.0))
        xformable.AddScaleOp(UsdGeom.XformOp.PrecisionDouble).Set((1.0, 1.0, 1.0))


def _select(path: str, wanted: bool) -> None:
    if wanted:
        current().selection.set_selected_prim_paths([path])
