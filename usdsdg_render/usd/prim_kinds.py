"""What single prims are to the renderer, and where they stand in their parents."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import numpy as np
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdLux, UsdShade

from usdsdg import errors
from usdsdg_render.scene.structs import LIGHT_CYLINDER, LIGHT_DISK, LIGHT_DISTANT, LIGHT_RECT, LIGHT_SPHERE

# What a prim is to the renderer.
PASS, MESH, SHAPE, CURVES, POINTS, LIGHT, DOME, INSTANCER, SUBSET, SKIP, UNDRAWN, NO_LIGHT = range(12)
GPRIMS = (MESH, SHAPE, CURVES, POINTS)
DRAWN_PURPOSES = (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)

# Properties that change nothing that is drawn; other engines and scripts write them all the time.
IGNORED_PREFIXES = ("physics:", "physx", "semantic", "newton:", "ui:", "userProperties:", "state:", "drive:")

# And schemas that do not when they are applied.
IGNORED_SCHEMAS = ("Semantics", "Physics", "Physx", "Newton")

# Parameters of each shape, with the schema's fallback for a prim that cannot resolve them.
SHAPE_PARAMETERS: dict[str, dict[str, float]] = {
    "Cube": {"size": 2.0},
    "Sphere": {"radius": 1.0},
    "Cylinder": {"radius": 1.0, "height": 2.0},
    "Cylinder_1": {"radiusBottom": 1.0, "radiusTop": 1.0, "height": 2.0},
    "Cone": {"radius": 1.0, "height": 2.0},
    "Capsule": {"radius": 0.5, "height": 1.0},
    "Capsule_1": {"radiusBottom": 0.5, "radiusTop": 0.5, "height": 1.0},
    "Plane": {"width": 2.0, "length": 2.0},
}

# Types of lights.
LIGHT_TYPES = {
    "SphereLight": LIGHT_SPHERE,
    "DistantLight": LIGHT_DISTANT,
    "RectLight": LIGHT_RECT,
    "DiskLight": LIGHT_DISK,
    "CylinderLight": LIGHT_CYLINDER,
}
DOME_TYPES = ("DomeLight", "DomeLight_1")
UNSUPPORTED_LIGHT_TYPES = ("PortalLight", "GeometryLight", "PluginLight")

_KNOWN = {
    "Mesh": MESH,
    "BasisCurves": CURVES,
    "HermiteCurves": CURVES,
    "NurbsCurves": CURVES,
    "Points": POINTS,
    "PointInstancer": INSTANCER,
    "GeomSubset": SUBSET,
    **dict.fromkeys(SHAPE_PARAMETERS, SHAPE),
    **dict.fromkeys(LIGHT_TYPES, LIGHT),
    **dict.fromkeys(DOME_TYPES, DOME),
    **dict.fromkeys(UNSUPPORTED_LIGHT_TYPES, NO_LIGHT),
    "Material": SKIP,
    "Shader": SKIP,
    "NodeGraph": SKIP,
}


def kind_of(prim: Usd.Prim) -> int:
    """What the prim is, by its type name; types that we have not met are asked once for what they derive from."""
    name = str(prim.GetTypeName())
    kind = _KNOWN.get(name)
    if kind is None:
        if prim.IsA(UsdGeom.Mesh):
            kind = MESH
        elif prim.IsA(UsdGeom.PointInstancer):
            kind = INSTANCER
        elif prim.IsA(UsdGeom.Gprim):
            kind = UNDRAWN
        elif prim.IsA(UsdLux.NonboundableLightBase) or prim.IsA(UsdLux.BoundableLightBase):
            kind = NO_LIGHT
        elif prim.IsA(UsdShade.NodeGraph):
            kind = SKIP
        else:
            kind = PASS
        _KNOWN[name] = kind
    return kind


def schemas_of(prim: Usd.Prim) -> tuple[str, ...]:
    """Applied schemas that may change what is drawn."""
    names = prim.GetPrimTypeInfo().GetAppliedAPISchemas()
    return tuple(name for name in names if not name.startswith(IGNORED_SCHEMAS)) if names else ()


def purpose_of(prim: Usd.Prim, inherited: str) -> str:
    """Purpose authored here, else the parent's. The empty string stands for "none authored"."""
    attribute = prim.GetAttribute("purpose")
    if attribute and attribute.HasAuthoredValue():
        return str(attribute.Get())
    return inherited


def is_invisible(prim: Usd.Prim, time: Usd.TimeCode) -> bool:
    attribute = prim.GetAttribute("visibility")
    return bool(attribute) and attribute.Get(time) == UsdGeom.Tokens.invisible


def local_matrix(cache: UsdGeom.XformCache, prim: Usd.Prim, sampled: bool) -> tuple[Gf.Matrix4d, bool]:
    """(local matrix, whether it starts a new transform stack).

    At the default time, a prim whose ops have only samples is where its first sample puts it. Ops that USD refuses give
    NaN, so that what they place is dropped by name.
    """
    try:
        matrix, resets = cache.GetLocalTransformation(prim)
    except Tf.ErrorException as failure:
        errors.warn_once(f"{prim.GetPath()}: its xformOps cannot be read. Correct xformOpOrder and its ops. {failure}")
        return Gf.Matrix4d(*[math.nan] * 16), False
    if sampled:
        xformable = UsdGeom.Xformable(prim)
        if xformable and xformable.TransformMightBeTimeVarying():
            ops = xformable.GetOrderedXformOps()
            if not any(op.Get() is not None for op in ops):
                matrix = xformable.GetLocalTransformation(Usd.TimeCode.EarliestTime())
    return matrix, resets


def local_matrices(
    cache: UsdGeom.XformCache, prims: Sequence[Usd.Prim], sampled: bool
) -> list[tuple[Gf.Matrix4d, bool]]:
    """`local_matrix` of many prims."""
    if not sampled:
        try:
            return list(map(cache.GetLocalTransformation, prims))
        except Tf.ErrorException:  # of one of them
            pass
    return [local_matrix(cache, prim, sampled) for prim in prims]


def matrix_product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a @ b, quietly: what is NaN or infinite is dropped by name where it would be drawn."""
    with np.errstate(invalid="ignore", over="ignore"):
        return a @ b


def is_below(path: Sdf.Path, roots: Collection[Sdf.Path]) -> bool:
    """Whether `path` is one of `roots` or below one."""
    if len(roots) < 8:
        return any(map(path.HasPrefix, roots))
    return Sdf.Path.absoluteRootPath in roots or any(prefix in roots for prefix in path.GetPrefixes())


def is_material_subset(subset: Usd.Prim) -> bool:
    """Whether a GeomSubset partitions the faces of its mesh for materials."""
    family = subset.GetAttribute("familyName").Get()
    element = subset.GetAttribute("elementType").Get()
    if family == UsdShade.Tokens.materialBind and element in (None, UsdGeom.Tokens.face):
        return True
    binding = subset.GetRelationship("material:binding")
    if binding and binding.HasAuthoredTargets():
        errors.warn_once(
            f"{subset.GetPath()}: its material does not count, since its familyName is {str(family or '')!r} and its "
            f"elementType {element}. Give it the familyName materialBind and the elementType face."
        )
    return False


def warn_unsupported(prim: Usd.Prim) -> None:
    """Name a gprim or light of a kind that is not drawn."""
    kind = prim.GetTypeName()
    if kind == "PortalLight":
        errors.warn_once(
            f"{prim.GetPath()}: PortalLight is not supported and changes nothing: it would only guide how a dome light "
            f"is sampled. Give the picture more samples where light comes through openings."
        )
        return
    what = "shines no light" if kind_of(prim) == NO_LIGHT else "is not drawn"
    remedy = (
        "Use one of the lights " + ", ".join((*LIGHT_TYPES, *DOME_TYPES))
        if kind_of(prim) == NO_LIGHT
        else "Convert it to a Mesh"
    )
    errors.warn_once(f"{prim.GetPath()}: {kind} is not supported and {what}. {remedy}.")
