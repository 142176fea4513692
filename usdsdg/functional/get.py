"""Search for prims by path, type and labels: `rep.functional.get`.

The first argument is the stage, by default the current one; the others are those of `rep.get`, except that matching is
case-sensitive by default, and the result is a list of pxr prims in stage order.
"""

import re
from collections.abc import Callable
from typing import Any

from pxr import Usd, UsdGeom, UsdShade

from usdsdg.arguments.parameters import name_parameters
from usdsdg.arguments.values import labels_of, shown
from usdsdg.errors import ArgumentError
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.materials import is_preview
from usdsdg.stage.paths import prim_at
from usdsdg.stage.semantics.labels import get_labels


def prims(
    stage: Usd.Stage | None = None, path_pattern: str | None = None, path_match: str | None = None,
    path_pattern_exclusion: str | None = None, prim_types: Any = None, prim_types_exclusion: Any = None,
    semantics: Any = None, semantics_exclusion: Any = None, ignore_case: bool = False,
) -> list[Usd.Prim]:  # fmt: skip
    """Find the prims that meet all given conditions, those that are inactive, classes or inside instances left out.

    Args:
        path_pattern: regular expression that must be found in the path; `path_pattern_exclusion` must not be found.
        path_match: substring of the path.
        prim_types: type or list of types, case-insensitive; `prim_types_exclusion` likewise.
        semantics: pairs of type and label, [("class", "cube")] or {"class": "cube"}; a prim matches if it has a label
            of that type which contains the given one, for any of the pairs; of shapes and subsets labels of their
            material count too. `semantics_exclusion` likewise.
        ignore_case: whether paths match case-insensitively.

    Raises:
        ArgumentError: a pattern is not a regular expression, or `semantics` are not labels.
    """
    matches = [
        _pattern("path_pattern", path_pattern, ignore_case),
        _without(_pattern("path_pattern_exclusion", path_pattern_exclusion, ignore_case)),
        _containing(path_match, ignore_case),
        _typed(prim_types),
        # The UsdPreviewSurface beside an OmniPBR shader is ours: in Omniverse such a material has one shader.
        None if prim_types is None else _without(is_preview),
        _without(_typed(prim_types_exclusion)),
        _labeled(semantics),
        _without(_labeled(semantics_exclusion)),
    ]
    wanted = [match for match in matches if match is not None]
    found = (stage or current_stage()).Traverse()
    return [prim for prim in found if all(match(prim) for match in wanted)]


def prim_at_path(stage: Usd.Stage | None, path: Any) -> Any:
    """Return the prim at a path, or a list of prims for a list of paths; the stage is by default the current one.

    Raises:
        BadPrim: there is none; the message says how far the path exists.
    """
    if isinstance(path, (list, tuple)):
        return [prim_at(stage or current_stage(), str(each)) for each in path]
    return prim_at(stage or current_stage(), str(path))


def prim_at_paths(stage: Usd.Stage | None, paths: Any) -> list[Usd.Prim]:
    """Return the prims at one path or a list of these, as a list in either case; see `prim_at_path`."""
    return prim_at_path(stage, list(paths) if isinstance(paths, (list, tuple)) else [paths])


_Match = Callable[[Usd.Prim], bool]


def _pattern(name: str, pattern: str | None, ignore_case: bool) -> _Match | None:
    if pattern is None:
        return None
    _check_text(name, pattern)
    try:
        compiled = re.compile(pattern, re.IGNORECASE if ignore_case else 0)
    except re.error as error:
        hint = f"; for any characters write '.*', as in {pattern.replace('*', '.*')!r}" if "*" in pattern else ""
        raise ArgumentError(f"{name} is {shown(pattern)}, which is not a regular expression: {error}{hint}") from error
    return lambda prim: compiled.search(prim.GetPath().pathString) is not None


def _check_text(name: str, given: Any) -> None:
    if not isinstance(given, str):
        hint = ""
        if isinstance(given, (list, tuple)):
            hint = (
                "; for several write one regular expression, path_pattern='a|b', or give paths to rep.get.prim_at_path"
            )
        raise ArgumentError(f"{name} is {shown(given)}; expected one text{hint}")


def _containing(text: str | None, ignore_case: bool) -> _Match | None:
    if text is None:
        return None
    _check_text("path_match", text)
    if ignore_case:
        return lambda prim: text.lower() in prim.GetPath().pathString.lower()
    return lambda prim: text in prim.GetPath().pathString


def _typed(types: Any) -> _Match | None:
    if types is None:
        return None
    known = {str(each).lower() for each in ([types] if isinstance(types, str) else types)}
    return lambda prim: str(prim.GetTypeName()).lower() in known


def _labeled(semantics: Any) -> _Match | None:
    if semantics is None:
        return None
    if isinstance(semantics, tuple) and len(semantics) == 2 and isinstance(semantics[0], str):
        semantics = [semantics]
    wanted = [(kind, label) for kind, labels in labels_of(semantics).items() for label in labels]

    def has(prim: Usd.Prim) -> bool:
        own = get_labels(prim)
        return any(label in each for kind, label in wanted for each in own.get(kind, ()))

    def match(prim: Usd.Prim) -> bool:
        if has(prim) or not (prim.IsA(UsdGeom.Gprim) or prim.IsA(UsdGeom.Subset)):
            return has(prim)
        material = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
        return bool(material) and has(material.GetPrim())

    return match


def _without(match: _Match | None) -> _Match | None:
    return None if match is None else lambda prim: not match(prim)


def _by_types(name: str, types: list[str], what: str) -> Callable[..., list[Usd.Prim]]:
    """Return a search function like `prims` for fixed prim types."""

    def get(
        stage: Usd.Stage | None = None, path_pattern: str | None = None, path_pattern_exclusion: str | None = None,
        semantics: Any = None, semantics_exclusion: Any = None, path_match: str | None = None,
        ignore_case: bool = False,
    ) -> list[Usd.Prim]:  # fmt: skip
        return prims(
            stage, path_pattern, path_match, path_pattern_exclusion, types, None, semantics, semantics_exclusion,
            ignore_case=ignore_case,
        )  # fmt: skip

    get.__name__ = get.__qualname__ = name
    get.__doc__ = f"{what}; see `prims` for the arguments."
    return get


_SHAPES = ["Sphere", "Cube", "Cylinder", "Cone", "Capsule", "Plane"]
_CURVES = ["BasisCurves", "NurbsCurves", "HermiteCurves"]
_LIGHTS = [
    "CylinderLight", "DiskLight", "DistantLight", "DomeLight", "DomeLight_1", "GeometryLight", "PortalLight",
    "RectLight", "SphereLight",
]  # fmt: skip
_PHYSICS = [
    "PhysicsScene", "PhysicsJoint", "PhysicsFixedJoint", "PhysicsRevoluteJoint", "PhysicsPrismaticJoint",
    "PhysicsSphericalJoint", "PhysicsDistanceJoint", "PhysicsCollisionGroup",
]  # fmt: skip

camera = _by_types("camera", ["Camera"], "Cameras")
curve = _by_types("curve", _CURVES, "Curves")
geomsubset = _by_types("geomsubset", ["GeomSubset"], "Subsets of meshes")
graph = _by_types("graph", ["OmniGraph"], "Graphs")
light = _by_types("light", _LIGHTS, "Lights of every type")
listener = _by_types("listener", ["OmniListener", "Listener"], "Listeners of spatial audio")
material = _by_types("material", ["Material"], "Materials")
mesh = _by_types("mesh", ["Mesh"], "Meshes")
physics = _by_types("physics", _PHYSICS, "Physics scenes, joints and collision groups")
renderproduct = _by_types("renderproduct", ["RenderProduct"], "Render products")
rendervar = _by_types("rendervar", ["RenderVar"], "Render variables")
scope = _by_types("scope", ["Scope"], "Scopes")
shader = _by_types("shader", ["Shader"], "Shaders")
shape = _by_types("shape", _SHAPES, "UsdGeom shapes")
skelanimation = _by_types("skelanimation", ["SkelAnimation"], "Skeleton animations")
skeleton = _by_types("skeleton", ["Skeleton"], "Skeletons")
sound = _by_types("sound", ["OmniSound", "SpatialAudio", "Sound"], "Sounds")
xform = _by_types("xform", ["Xform"], "Transforms")

name_parameters(globals())
