"""Search for prims by kind, and their bounding boxes, variants and transforms."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdShade

from usdsdg import modify
from usdsdg.arguments.prims import prim_at
from usdsdg.arguments.values import labels_of
from usdsdg.errors import ArgumentError, BadPrim
from usdsdg.graph.node import prim_paths
from usdsdg.stage.poses import transforms
from usdsdg.stage.semantics.labels import get_labels


def get_prims_from_paths(paths: Sequence[Any]) -> list[Usd.Prim]:
    """Return the prims at the given paths.

    Raises:
        BadPrim: one of them is not on the stage.
    """
    return [prim_at(path) for path in prim_paths(paths)]


def get_non_xform_prims(prim_paths: Any) -> list[str]:
    """Return paths of the prims with geometry, light or camera: the children of a Replicator object, else the prim."""
    return [str(each.GetPath()) for prim in get_prims_from_paths(prim_paths) for each in modify.non_xform_prims(prim)]


_MODES: dict[str, Callable[[Usd.Prim], bool]] = {
    "instances": Usd.Prim.IsInstance,
    "materials": lambda prim: prim.IsA(UsdShade.Material),
    "meshes": lambda prim: prim.IsA(UsdGeom.Mesh),
    "prims": lambda prim: True,
}


def find_prims(prim_paths: Any, mode: str = "instances") -> list[str]:
    """Return paths of prims at and below the given ones, selected by `mode`.

    Args:
        mode: "instances", "prototypes" (of these), "meshes", "materials" or "prims" (all).

    Raises:
        ArgumentError: the mode does not exist.
        BadPrim: a path is not on the stage.
    """
    if mode not in _MODES and mode != "prototypes":
        raise ArgumentError(f"utils.find_prims: mode={mode!r}; known: {', '.join(_MODES)}, prototypes")
    below = [prim for root in get_prims_from_paths(prim_paths) for prim in Usd.PrimRange(root)]
    if mode == "prototypes":
        return list(dict.fromkeys(str(prim.GetPrototype().GetPath()) for prim in below if prim.IsInstance()))
    return [str(prim.GetPath()) for prim in below if _MODES[mode](prim)]


def get_prim_variant_values(prim_path: Any, variant_name: str) -> list[str]:
    """Return the variant names of a prim's variant set.

    Raises:
        BadPrim: there is no such prim, or it has no such variant set.
    """
    (prim,) = get_prims_from_paths([prim_path])
    sets = prim.GetVariantSets()
    if variant_name not in sets.GetNames():
        known = ", ".join(sets.GetNames()) or "none"
        raise BadPrim(f"{prim.GetPath()} has no variant set {variant_name!r}; it has: {known}")
    return list(sets.GetVariantSet(variant_name).GetVariantNames())


def compute_aabb(bbox_cache: UsdGeom.BBoxCache, prim: Any, include_children: bool = True) -> np.ndarray:
    """Compute the world-aligned bounding box of a prim, (6,) lowest and highest corner [stage units].

    Without children it is the box of the prim's own extent. For a prim without extent the lowest corner is +inf, the
    highest -inf.
    """
    (prim,) = get_prims_from_paths([prim])
    if include_children:
        box = bbox_cache.ComputeWorldBound(prim).ComputeAlignedRange()
    else:
        extent = UsdGeom.Boundable(prim).GetExtentAttr().Get() if prim.IsA(UsdGeom.Boundable) else None
        local = Gf.Range3d(*(Gf.Vec3d(corner) for corner in extent)) if extent else Gf.Range3d()
        box = Gf.BBox3d(local, transforms.local_to_world(prim)).ComputeAlignedRange()
    if box.IsEmpty():
        return np.array([np.inf] * 3 + [-np.inf] * 3)
    return np.array([*box.GetMin(), *box.GetMax()])


def parse_semantics(prim: Any) -> list[tuple[str, str]]:
    """Return the labels of a prim and of the material bound to it, as pairs of a type and a label."""
    (prim,) = get_prims_from_paths([prim])
    material = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
    owners = [prim, material.GetPrim()] if material else [prim]
    return [(kind, label) for owner in owners for kind, found in get_labels(owner).items() for label in found]


def legacy_semantics_arg_to_new(legacy_semantics_arg: Any) -> Any:
    """Convert pairs [("class", "cube")] or texts ["class:cube"] to {"class": ["cube"]}; other values stay."""
    return labels_of(legacy_semantics_arg) if isinstance(legacy_semantics_arg, list) else legacy_semantics_arg


def read_prim_transform(prim: Any) -> Gf.Matrix4d:
    """Return the local-to-world matrix of a prim, for row vectors [stage units]."""
    return transforms.local_to_world(get_prims_from_paths([prim])[0])
