"""References to files and prims, and copies of prims."""

from typing import Any

from pxr import Sdf, Usd, UsdGeom, UsdUtils

from usdsdg.arguments.prims import one_prim
from usdsdg.errors import ArgumentError, AssetError
from usdsdg.functional.arguments import per_prim
from usdsdg.functional.new_prims import add_missing_ops, apply_common_arguments, define, new_paths
from usdsdg.session.stage_context import current_stage
from usdsdg.stage import assets
from usdsdg.stage.paths import prim_at
from usdsdg.stage.paths import prim_path as checked_path
from usdsdg.stage.prims.copies import copy_prim


def reference(
    usd_path: Any = None, prim_path: Any = None, position: Any = None, scale: Any = None, rotation: Any = None,
    look_at: Any = None, look_at_up_axis: Any = None, pivot: Any = None, relative_to: Any = None,
    semantics: Any = None, visible: Any = True, count: int = 1, name: str | None = None, parent: Any = None,
) -> list[Usd.Prim]:  # fmt: skip
    """Create references to a USD file (`usd_path`: a file, or a URL below the assets root) or to a prim of this stage.

    `prim_path` selects a prim of the file, by default its default prim; without a file it is a prim of this stage. Both
    may be lists with one value per reference. The name is "Ref" by default. Poses are written to the xform ops of the
    referenced prim; if it has none, translate, orient and scale ops are added.

    Raises:
        AssetNotFound: there is no such file.
        AssetError: the file has no such prim, or no default prim.
        ArgumentError: neither `usd_path` nor `prim_path` is given.
    """
    if usd_path is None and prim_path is None:
        raise ArgumentError("reference needs usd_path, the file to refer to, or prim_path, a prim of this stage")
    chosen = [_target(file, prim) for file, prim in zip(per_prim(usd_path, count), per_prim(prim_path, count))]
    prims = define(new_paths(name or "Ref", parent, count), "", with_ops=False)
    with Sdf.ChangeBlock():
        for prim, target in zip(prims, chosen):
            prim.GetReferences().AddReference(target)
    add_missing_ops(prims)
    return apply_common_arguments(
        prims, position=position, scale=scale, rotation=rotation, look_at=look_at, look_at_up_axis=look_at_up_axis,
        pivot=pivot, relative_to=relative_to, semantics=semantics, visible=visible,
    )  # fmt: skip


def clone(
    path: Any, position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None,
    look_at_up_axis: Any = None, pivot: Any = None, relative_to: Any = None, semantics: Any = None,
    visible: Any = True, count: int = 1, name: str | None = None, parent: Any = None,
) -> list[Usd.Prim]:  # fmt: skip
    """Copy a prim with all descendants; references stay references. By default the copies are root prims.

    The default name is that of the source. Relationship and connection targets inside the source are remapped to the
    copy.

    Raises:
        BadPrim: there is no prim at `path`.
    """
    source = prim_at(current_stage(), path) if isinstance(path, str) else one_prim("path", path)
    paths = new_paths(name or source.GetName(), parent, count)
    stage = source.GetStage()
    copy_prim(stage, _layer_with(stage, source.GetPath()), source.GetPath(), paths)
    prims = [stage.GetPrimAtPath(each) for each in paths]
    add_missing_ops([prim for prim in prims if prim.IsA(UsdGeom.Xformable)])
    return apply_common_arguments(
        prims, position=position, scale=scale, rotation=rotation, look_at=look_at, look_at_up_axis=look_at_up_axis,
        pivot=pivot, relative_to=relative_to, semantics=semantics, visible=visible,
    )  # fmt: skip


def _target(file: Any, prim: Any) -> Sdf.Reference:
    """Return the reference to a prim of a file or of this stage, after checking that it exists."""
    inside = Sdf.Path() if prim is None else checked_path(str(prim))
    if file is None:
        prim_at(current_stage(), inside)
        return Sdf.Reference("", inside)
    if inside.isEmpty:
        return Sdf.Reference(assets.resolve_object(str(file), remedy="pass prim_path"))
    resolved = assets.resolve(str(file))
    # The stage must outlive its prims.
    file_stage = Usd.Stage.Open(assets.open_layer(resolved), Usd.Stage.LoadNone)
    if not file_stage.GetPrimAtPath(inside):
        raise AssetError(f"{resolved} has no prim {inside}")
    return Sdf.Reference(resolved, inside)


def _layer_with(stage: Usd.Stage, path: Sdf.Path) -> Sdf.Layer:
    """Return a layer with all opinions of the stage's layer stack about a prim."""
    holding = [layer for layer in stage.GetLayerStack() if layer.GetPrimAtPath(path)]
    return holding[0] if len(holding) == 1 else UsdUtils.FlattenLayerStack(stage)
