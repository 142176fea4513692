"""Classify prims by what the renderer does with them."""

from pxr import Usd, UsdGeom, UsdLux, UsdShade

from usdsdg import errors
from usdsdg.stage.geometry.drawn_box import DRAWN_PURPOSES
from usdsdg_render.scene.structs import LIGHT_CYLINDER, LIGHT_DISK, LIGHT_DISTANT, LIGHT_RECT, LIGHT_SPHERE

# The kinds. OTHER has no surface of its own: an Xform, a Scope, a camera, a type that USD does not know.
# A TetMesh is a MESH, by its surface.
MESH, SHAPE, CURVES, POINTS, PATCH, LIGHT, DOME, INSTANCER, SUBSET, SHADING, OTHER = range(11)
UNSUPPORTED_GPRIM, UNSUPPORTED_LIGHT = 11, 12
GPRIMS = (MESH, SHAPE, CURVES, POINTS, PATCH)
_PURPOSES = ("", *DRAWN_PURPOSES, UsdGeom.Tokens.proxy, UsdGeom.Tokens.guide)
# The last is not USD's, but clear.
_VISIBILITIES = (
    None,
    UsdGeom.Tokens.inherited,
    UsdGeom.Tokens.invisible,
    "visible",
)

# Handle of a property from which no image is read; see `Changes.handles`.
UNREAD = -1
# Properties that never change an image; other engines and scripts write them all the time.
IGNORED_PREFIXES = ("physics:", "physx", "semantic", "newton:", "ui:", "userProperties:", "state:", "drive:")

# Applied schemas that never change an image.
IGNORED_SCHEMAS = ("Semantics", "Physics", "Physx", "Newton")

# Types of shapes: the attributes that give their size, with their fallback values in the schema.
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

LIGHT_TYPES = {
    "SphereLight": LIGHT_SPHERE,
    "DistantLight": LIGHT_DISTANT,
    "RectLight": LIGHT_RECT,
    "DiskLight": LIGHT_DISK,
    "CylinderLight": LIGHT_CYLINDER,
}
DOME_TYPES = ("DomeLight", "DomeLight_1")
UNSUPPORTED_LIGHT_TYPES = ("PortalLight", "GeometryLight", "PluginLight")

_KIND_OF_TYPE = {
    "Mesh": MESH,
    "TetMesh": MESH,
    "NurbsPatch": PATCH,
    "BasisCurves": CURVES,
    "HermiteCurves": CURVES,
    "NurbsCurves": CURVES,
    "Points": POINTS,
    "PointInstancer": INSTANCER,
    "GeomSubset": SUBSET,
    **dict.fromkeys(SHAPE_PARAMETERS, SHAPE),
    **dict.fromkeys(LIGHT_TYPES, LIGHT),
    **dict.fromkeys(DOME_TYPES, DOME),
    **dict.fromkeys(UNSUPPORTED_LIGHT_TYPES, UNSUPPORTED_LIGHT),
    "Material": SHADING,
    "Shader": SHADING,
    "NodeGraph": SHADING,
    "GenerativeProcedural": UNSUPPORTED_GPRIM,  # a Boundable without points; SkelRoot is one, too
}


def kind_of(prim: Usd.Prim) -> int:
    """Return the kind of a prim by its type name. A type met for the first time is classified by its base schemas."""
    name = str(prim.GetTypeName())
    kind = _KIND_OF_TYPE.get(name)
    if kind is None:
        if prim.IsA(UsdGeom.Mesh):
            kind = MESH
        elif prim.IsA(UsdGeom.PointInstancer):
            kind = INSTANCER
        elif prim.IsA(UsdGeom.Gprim):
            kind = UNSUPPORTED_GPRIM
        elif prim.IsA(UsdLux.NonboundableLightBase) or prim.IsA(UsdLux.BoundableLightBase):
            kind = UNSUPPORTED_LIGHT
        elif prim.IsA(UsdShade.NodeGraph):
            kind = SHADING
        else:
            kind = OTHER
        _KIND_OF_TYPE[name] = kind
    return kind


def schemas_of(prim: Usd.Prim) -> tuple[str, ...]:
    """Return the applied schemas that may change an image."""
    names = prim.GetPrimTypeInfo().GetAppliedAPISchemas()
    return tuple(name for name in names if not name.startswith(IGNORED_SCHEMAS)) if names else ()


def purpose_of(prim: Usd.Prim, inherited: str) -> str:
    """Return the purpose authored on the prim, else the inherited one; "" stands for none authored."""
    attribute = prim.GetAttribute("purpose")
    if attribute and attribute.HasAuthoredValue():
        purpose = str(attribute.Get())
        if purpose not in _PURPOSES:
            errors.warn_once(
                f"{prim.GetPath()}: purpose {purpose!r} is none of {', '.join(_PURPOSES[1:])}, so it and what is below "
                "it is not drawn. Correct it."
            )
        return purpose
    return inherited


def is_invisible(prim: Usd.Prim, time: Usd.TimeCode) -> bool:
    """Whether the prim itself is authored invisible at `time`."""
    attribute = prim.GetAttribute("visibility")
    visibility = attribute.Get(time) if attribute else None
    warn_of_visibility(prim, visibility)
    return visibility == UsdGeom.Tokens.invisible


def warn_of_visibility(prim: Usd.Prim, visibility: str | None) -> None:
    """Warn of a value of `visibility` that USD does not know, and takes for "inherited"."""
    if visibility not in _VISIBILITIES:
        errors.warn_once(
            f"{prim.GetPath()}: visibility {visibility!r} is neither inherited nor invisible, so the prim is drawn. "
            "Correct it."
        )


def is_material_subset(subset: Usd.Prim) -> bool:
    """Whether a GeomSubset assigns a material to faces of its mesh."""
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


def warn_of_lone_subset(subset: Usd.Prim) -> None:
    """Warn of a material of faces that belong to no mesh."""
    binding = subset.GetRelationship("material:binding")
    if binding and binding.HasAuthoredTargets():
        errors.warn_once(
            f"{subset.GetPath()}: its material does not count, since subsets of faces are those of a Mesh that is "
            f"their parent, and {subset.GetParent().GetPath()} is none. Move it, or bind its material there."
        )


def warn_unsupported(prim: Usd.Prim) -> None:
    """Warn of a gprim or light of an unsupported type."""
    kind = prim.GetTypeName()
    if kind == "PortalLight":
        errors.warn_once(
            f"{prim.GetPath()}: PortalLight is not supported and changes nothing: it would only guide how a dome light "
            f"is sampled. Render more samples where light comes through openings."
        )
        return
    if kind_of(prim) == UNSUPPORTED_LIGHT:
        effect, remedy = "shines no light", "Use one of the lights " + ", ".join((*LIGHT_TYPES, *DOME_TYPES))
    else:
        effect, remedy = "is not drawn", "Convert it to a Mesh"
    errors.warn_once(f"{prim.GetPath()}: {kind} is not supported and {effect}. {remedy}.")
