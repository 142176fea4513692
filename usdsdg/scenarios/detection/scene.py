"""The stage of the detection job: a view with its camera, and all bodies that some frame shows."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pxr import Gf, Usd, UsdGeom

import usdsdg as rep
from usdsdg.calibration.calibration import author_calibration
from usdsdg.create.render_products import HydraTexture
from usdsdg.scenarios.detection.config import DetectionConfig
from usdsdg.scenarios.shared.backdrop import Backdrop
from usdsdg.scenarios.shared.bodies import Body, add_asset, add_shape
from usdsdg.scenarios.shared.decks import most_of_each
from usdsdg.scenarios.shared.lenses import DEFAULT_SIZE, author_field_of_view
from usdsdg.scenarios.shared.lighting import Brightness, Lighting
from usdsdg.scenarios.shared.mesh_folder import MeshAsset, files_by_label, read_assets
from usdsdg.scenarios.shared.patterns import pattern_folder
from usdsdg.scenarios.shared.pictures import Picture, pictures_in, skies_in
from usdsdg.scenarios.shared.sections import mounts_of
from usdsdg.session import stage_context
from usdsdg.stage.cameras.camera_view import CameraView, read_camera

# Nearest and farthest distance [m] that a camera sees: objects may be grains or houses.
_CLIPPING = (0.001, 10000.0)
_DISTRACTOR_POOL = 12  # of shapes, and of meshes


@dataclass(frozen=True)
class Scene:
    """Prims of the detection job. `view` is the parent of camera, bodies and backdrop, and turned for each frame."""

    view: Usd.Prim
    camera: Usd.Prim
    seen: CameraView  # in the frame of `view`
    objects: dict[tuple[str, int], list[Body]]  # by class and number of the shape
    distractors: list[Body]
    lighting: Lighting
    backdrop: Backdrop | None
    pictures: list[Picture]
    product: HydraTexture


def build(config: DetectionConfig, hands: Sequence[Sequence[tuple[str, int]]], assets: Sequence[MeshAsset]) -> Scene:
    """Create the stage; `hands` are the objects of each frame, by class and number of the shape.

    Raises:
        ConfigError, AssetError: a picture, a sky or a mesh cannot be used.
    """
    stage = stage_context.new_stage()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    rep.orchestrator.set_capture_on_play(False)
    view = stage.DefinePrim("/World/View", "Xform")
    camera, size = _camera(view, config)
    seen = read_camera(stage, camera.GetPath(), size)
    brightness = Brightness(config.lights.sky, config.lights.lamps, config.lights.lamp_count)
    with_pictures = config.backgrounds.share_of_pictures > 0.0
    pictures = pictures_in(config.backgrounds.pictures or pattern_folder()) if with_pictures else []
    return Scene(
        view,
        camera,
        seen,
        _objects(stage.DefinePrim("/World/View/Objects", "Xform"), hands, assets),
        _distractors(stage.DefinePrim("/World/View/Distractors", "Xform"), config),
        Lighting(stage, skies_in(config.backgrounds.skies), brightness),
        Backdrop(view, seen, pictures[0]) if pictures else None,
        pictures,
        rep.create.render_product(str(camera.GetPath()), size),
    )


def _camera(view: Usd.Prim, config: DetectionConfig) -> tuple[Usd.Prim, tuple[int, int]]:
    """Create the camera; return it with the size of its pictures."""
    camera = UsdGeom.Camera.Define(view.GetStage(), view.GetPath().AppendChild("Camera"))
    camera.CreateClippingRangeAttr(Gf.Vec2f(*_CLIPPING))
    mounts = mounts_of(config.camera)
    if mounts:
        author_calibration(camera.GetPrim(), mounts[0].calibration)
        return camera.GetPrim(), config.resolution or mounts[0].calibration.size
    author_field_of_view(camera, config.camera.field_of_view)
    return camera.GetPrim(), config.resolution or DEFAULT_SIZE


def _objects(
    parent: Usd.Prim, hands: Sequence[Sequence[tuple[str, int]]], assets: Sequence[MeshAsset]
) -> dict[tuple[str, int], list[Body]]:
    """Create as many of each shape as a frame has at most."""
    by_label: dict[str, list[MeshAsset]] = {}
    for asset in assets:
        by_label.setdefault(asset.label, []).append(asset)
    most = most_of_each(hands)
    return {
        (label, shape): [add_asset(parent, asset, labeled=True) for _ in range(most[label, shape])]
        for label, shapes in by_label.items()
        for shape, asset in enumerate(shapes)
    }


def _distractors(parent: Usd.Prim, config: DetectionConfig) -> list[Body]:
    wanted = config.distractors
    if not wanted.per_image[1]:
        return []
    pool = max(_DISTRACTOR_POOL, wanted.per_image[1])
    bodies = (
        [add_shape(parent, wanted.shapes[number % len(wanted.shapes)]) for number in range(pool)]
        if wanted.shapes
        else []
    )
    if wanted.meshes:
        found = read_assets(files_by_label(wanted.meshes), "auto")
        count = max(pool, len(found)) if not wanted.shapes else len(found)
        bodies += [add_asset(parent, found[number % len(found)], labeled=False) for number in range(count)]
    return bodies


def sizes_of(assets: Sequence[MeshAsset]) -> Mapping[str, int]:
    """Return the number of shapes of each class."""
    return Counter(asset.label for asset in assets)
