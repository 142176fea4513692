"""Search for prims by kind, and their bounding boxes, variants and transforms."""

from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

from usdsdg import modify
from usdsdg.arguments.prims import prim_at
from usdsdg.arguments.values import labels_of
from usdsdg.errors import ArgumentError, warn_once
from usdsdg.graph.node import prim_paths as paths_of
from usdsdg.session.stage_context import current_stage
from usdsdg.stage import paths
from usdsdg.stage.geometry.instancers import is_instancer, prototypes
from usdsdg.stage.materials import define_mdl
from usdsdg.stage.poses import transforms
from usdsdg.stage.semantics.labels import add_labels, get_labels

_MODES = ("instances", "prims", "meshes", "materials")


def get_prims_from_paths(prim_paths: Any) -> list[Usd.Prim]:
    """Return the prims at the given paths; those that are not on the stage are left out, with one warning for each.

    Raises:
        NotAPrim: one is neither a path nor a prim.
    """
    stage, found = current_stage(), []
    for path in paths_of(prim_paths):
        if Sdf.Path.IsValidPathString(path) and (prim := stage.GetPrimAtPath(path)):
            found.append(prim)
        else:
            warn_once(f"{path} is not a prim on the stage; it is left out")
    return found


def get_non_xform_prims(prim_paths: Any, usd_usdrt: bool = False) -> list[str]:
    """Return paths of the prims with geometry, light or camera: the children of a Replicator object, else the prim.

    Paths that are not on the stage are left out, with one warning for each; `usd_usdrt` has no effect, as both give
    the same paths.
    """
    return [str(each.GetPath()) for prim in get_prims_from_paths(prim_paths) for each in modify.non_xform_prims(prim)]


def find_prims(prim_paths: Any, mode: str = "instances") -> list[Any]:
    """Return the prims at the given paths, or what `mode` selects of them.

    Args:
        mode: "prims": those at the paths; "instances": the same with the prototypes of each PointInstancer in its
            place; "meshes": the Mesh and GeomSubset prims at and below these; "materials": the UsdShade.Material of
            each prim at and below these that has one.

    Raises:
        ArgumentError: (a ValueError) the mode does not exist.
        BadPrim: a path is not on the stage.
    """
    if mode not in _MODES:
        raise ArgumentError(f"utils.find_prims: mode={mode!r}; known: {', '.join(_MODES)}")
    prims = [prim_at(path) for path in paths_of(prim_paths)]
    if mode == "prims":
        return prims
    roots = [each for prim in prims for each in (prototypes(prim) if is_instancer(prim) else [prim])]
    if mode == "instances":
        return roots
    below = [prim for root in roots for prim in Usd.PrimRange(root)]
    if mode == "meshes":
        return [prim for prim in below if prim.GetTypeName() in ("Mesh", "GeomSubset")]
    return [material for material in UsdShade.MaterialBindingAPI.ComputeBoundMaterials(below)[0] if material]


def get_prim_variant_values(prim_path: Any, variant_name: str) -> list[str]:
    """Return the variant names of a prim's variant set; [], with a warning, where it has no such set.

    Raises:
        BadPrim: there is no such prim.
    """
    prim = _one_prim(prim_path)
    sets = prim.GetVariantSets()
    if variant_name not in sets.GetNames():
        known = ", ".join(sets.GetNames()) or "none"
        warn_once(f"{prim.GetPath()} has no variant set {variant_name!r}; it has: {known}")
        return []
    return list(sets.GetVariantSet(variant_name).GetVariantNames())


def compute_aabb(bbox_cache: UsdGeom.BBoxCache, prim: Any, include_children: bool = True) -> np.ndarray:
    """Compute the world-aligned bounding box of a prim, (6,) lowest and highest corner [stage units].

    It is the box of the prim and of all below it, also without `include_children`, as in Replicator. For a prim without
    extent the lowest corner is +inf, the highest -inf.
    """
    box = bbox_cache.ComputeWorldBound(_one_prim(prim)).ComputeAlignedRange()
    if box.IsEmpty():
        return np.array([np.inf] * 3 + [-np.inf] * 3)
    return np.array([*box.GetMin(), *box.GetMax()])


def is_camera_prim(prim: Any) -> bool:
    """Whether a prim, or what is at a path, is a camera, or the Xform that `create.camera` makes of one."""
    found = _one_prim(prim)
    if found.HasAttribute("replicatorXform") or found.HasAttribute("replicatorCameraXform"):
        return any(child.IsA(UsdGeom.Camera) for child in found.GetChildren())
    return found.IsA(UsdGeom.Camera)


def create_material(mtl_url: str, mtl_name: str, mtl_path: str) -> None:
    """Define a material whose surface is the material `mtl_name` of an MDL file, at the next free path.

    Prims above it that do not exist become Scopes.
    """
    stage = current_stage()
    path = Sdf.Path(paths.next_free_path(stage, mtl_path))
    for above in path.GetParentPath().GetPrefixes():
        if not stage.GetPrimAtPath(above):
            stage.DefinePrim(above, "Scope")
    material = define_mdl(stage, str(path), mtl_url.replace("\\", "/"))
    UsdShade.Shader(material.GetPrim().GetChild("Shader")).SetSourceAssetSubIdentifier(mtl_name, "mdl")


def parse_semantics(prim: Any) -> list[tuple[str, str]]:
    """Return the labels of a prim and of the material bound to it, as pairs of a type and a label."""
    prim = _one_prim(prim)
    material = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
    owners = [prim, material.GetPrim()] if material else [prim]
    return [(kind, label) for owner in owners for kind, found in get_labels(owner).items() for label in found]


def legacy_semantics_arg_to_new(legacy_semantics_arg: Any) -> Any:
    """Convert pairs [("class", "cube")] or texts ["class:cube"] to {"class": ["cube"]}; other values stay."""
    return labels_of(legacy_semantics_arg) if isinstance(legacy_semantics_arg, list) else legacy_semantics_arg


def _set_semantics_legacy(prim: Usd.Prim, semantics: Any) -> None:
    """Add labels to a prim, as scripts do that know the inner functions of Replicator.

    Raises:
        BadPrim: there is no such prim, or it cannot be edited.
    """
    add_labels(prim, labels_of(semantics))


def read_prim_transform(prim: Any) -> Gf.Matrix4d:
    """Return the local-to-world matrix of a prim, for row vectors [stage units]."""
    return transforms.local_to_world(_one_prim(prim))


def _one_prim(prim: Any) -> Usd.Prim:
    (path,) = paths_of([prim])
    return prim_at(path)
