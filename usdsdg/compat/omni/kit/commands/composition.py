"""Commands that change what prims are composed of, how they are grouped, and whether they take part."""

from __future__ import annotations

from collections.abc import Sequence

from pxr import Sdf, Usd, UsdGeom

from usdsdg.compat.omni.kit.commands.prims import move_prim
from usdsdg.compat.omni.kit.commands.registry import command
from usdsdg.errors import BadPrim
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.paths import next_free_path

AnyPath = str | Sdf.Path


@command("CreateInstance")
def create_instance(path_from: AnyPath) -> str:
    """Define an instance of a prim beside it; return its path."""
    stage = current_stage()
    source = _prim(stage, "CreateInstance", path_from)
    path = next_free_path(stage, str(source.GetPath()))
    made = stage.DefinePrim(path, source.GetTypeName())
    made.GetReferences().AddInternalReference(source.GetPath())
    made.SetInstanceable(True)
    return path


@command("CreateInstances")
def create_instances(paths_from: Sequence[AnyPath]) -> list[str]:
    """Define an instance of each prim; return their paths."""
    return [create_instance(path) for path in paths_from]


@command("RemoveReference")
def remove_reference(prim_path: AnyPath, reference: Sdf.Reference, stage: Usd.Stage | None = None) -> None:
    """Remove a reference of a prim."""
    _prim(stage, "RemoveReference", prim_path).GetReferences().RemoveReference(reference)


@command("RemovePayload")
def remove_payload(prim_path: AnyPath, payload: Sdf.Payload, stage: Usd.Stage | None = None) -> None:
    """Remove a payload of a prim."""
    _prim(stage, "RemovePayload", prim_path).GetPayloads().RemovePayload(payload)


@command("ReplaceReference")
def replace_reference(
    prim_path: AnyPath, old_reference: Sdf.Reference, new_reference: Sdf.Reference, stage: Usd.Stage | None = None
) -> None:
    """Replace a reference of a prim by another one."""
    references = _prim(stage, "ReplaceReference", prim_path).GetReferences()
    references.RemoveReference(old_reference)
    references.AddReference(new_reference)


@command("ToggleActivePrims")
def toggle_active_prims(prim_paths: Sequence[AnyPath], active: bool) -> None:
    """Let prims take part in the stage, or not."""
    for path in prim_paths:
        _prim(None, "ToggleActivePrims", path).SetActive(bool(active))


@command("UngroupPrims")
def ungroup_prims(prim_paths: Sequence[AnyPath], stage: Usd.Stage | None = None) -> None:
    """Move the children of prims to their parents, in place in the world, and remove the prims.

    Prims without children and shapes with some stay.
    """
    target = stage or current_stage()
    for path in prim_paths:
        group = _prim(target, "UngroupPrims", path)
        if not group.GetChildren() or group.IsA(UsdGeom.Gprim):
            continue
        parent = group.GetPath().GetParentPath()
        for child in [each.GetPath() for each in group.GetChildren()]:
            free = next_free_path(target, str(parent.AppendChild(child.name)))
            move_prim(child, free, stage_or_context=target)
        target.RemovePrim(group.GetPath())


def _prim(stage: Usd.Stage | None, caller: str, path: AnyPath) -> Usd.Prim:
    prim = (stage or current_stage()).GetPrimAtPath(str(path))
    if not prim:
        raise BadPrim(f"{caller}: {path} is not on the stage")
    return prim
