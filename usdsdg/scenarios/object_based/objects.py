"""Rigid bodies in the working area: labeled assets, and distractors without labels."""

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from pxr import Gf, Usd

from usdsdg.errors import warn_once
from usdsdg.meshes.placement import LARGEST, SMALLEST
from usdsdg.scenarios import rigid_bodies
from usdsdg.scenarios.draws import Draws, Placement
from usdsdg.scenarios.object_based.config import ObjectBasedConfig
from usdsdg.stage import assets
from usdsdg.stage.geometry.drawn_box import DRAWN_PURPOSES
from usdsdg.stage.geometry.own_box import own_box
from usdsdg.stage.paths import next_free_path, valid_name
from usdsdg.stage.poses.transforms import local_to_world, meters_per_unit
from usdsdg.stage.poses.xform_ops import author_pose
from usdsdg.stage.semantics import labels


@dataclass
class Bodies:
    """Prims of one kind, separated by whether gravity acts on them."""

    floating: list[Usd.Prim] = field(default_factory=list)
    falling: list[Usd.Prim] = field(default_factory=list)

    def add(self, prim: Usd.Prim, placement: Placement, *, floating: bool) -> None:
        """Pose a prim, make it a rigid body, and add it to the floating or to the falling ones."""
        author_pose(prim, translate=placement.position, rotate_xyz=placement.rotation, scale=(placement.scale,) * 3)
        rigid_bodies.add_colliders(prim)
        rigid_bodies.add_rigid_body(prim, floating=floating)
        (self.floating if floating else self.falling).append(prim)

    @property
    def all(self) -> list[Usd.Prim]:
        """All prims, floating ones first."""
        return [*self.floating, *self.falling]


def add_labeled_assets(stage: Usd.Stage, config: ObjectBasedConfig, draws: Draws) -> Bodies:
    """Add the labeled objects, each with its class label."""
    bodies, seen, area = Bodies(), Counter(), _working_area(config)
    for asset in config.labeled_assets_and_properties:
        # Two entries with the same label draw different poses.
        purpose = f"labeled/{asset.label}#{seen[asset.label]}"
        seen[asset.label] += 1
        for index in range(asset.count):
            placement = draws.placement(purpose, index, *area, asset.scale_range)
            prim = _reference(stage, f"/World/Labeled/{valid_name(asset.label)}", asset.url)
            bodies.add(prim, placement, floating=asset.floating)
            labels.add_labels(prim, {"class": [asset.label]}, mode="replace")
            if index == 0 and not assets.is_mesh(asset.url):  # the size of a mesh is named where it is converted
                _name_odd_size(prim, asset.url)
    return bodies


def add_shape_distractors(stage: Usd.Stage, config: ObjectBasedConfig, draws: Draws) -> Bodies:
    """Add distractors of basic shapes, without labels."""
    bodies, area = Bodies(), _working_area(config)
    for index in range(config.shape_distractors_wanted):
        placement = draws.placement("shape", index, *area, config.shape_distractors_scale_min_max)
        shape = draws.choice("shape/type", index, config.shape_distractors_types)
        floating = draws.choice("shape/floating", index, (True, False))
        prim = stage.DefinePrim(next_free_path(stage, f"/World/Distractors/{shape}"), shape.capitalize())
        bodies.add(prim, placement, floating=floating)
    return bodies


def add_mesh_distractors(stage: Usd.Stage, config: ObjectBasedConfig, draws: Draws) -> Bodies:
    """Add distractors from assets, with the labels of the assets removed."""
    bodies, area = Bodies(), _working_area(config)
    for index in range(config.mesh_distractors_wanted):
        placement = draws.placement("mesh", index, *area, config.mesh_distractors_scale_min_max)
        url = draws.choice("mesh/url", index, config.mesh_distractors_urls)
        floating = draws.choice("mesh/floating", index, (True, False))
        name = valid_name(Path(url).name.split(".")[0])
        prim = _reference(stage, f"/World/Distractors/{name}", url)
        bodies.add(prim, placement, floating=floating)
        labels.remove_labels(prim, recursive=True)
    return bodies


def _name_odd_size(prim: Usd.Prim, url: str) -> None:
    """Warn of an object whose size on the stage looks like a mistake of units."""
    own = own_box(prim, DRAWN_PURPOSES)
    bounds = Gf.BBox3d(own, local_to_world(prim)).ComputeAlignedRange()
    largest = max(bounds.GetSize()) * meters_per_unit(prim.GetStage())
    if not bounds.IsEmpty() and not SMALLEST <= largest <= LARGEST:
        warn_once(
            f"{url} is {largest:.4g} m large on the stage, which is odd for an object; set its scale_min_max, or give "
            "its file the units of the stage"
        )


def _working_area(config: ObjectBasedConfig) -> tuple[list[float], list[float]]:
    half = [extent / 2.0 for extent in config.working_area_size]
    return [-extent for extent in half], half


def _reference(stage: Usd.Stage, path: str, url: str) -> Usd.Prim:
    prim = stage.DefinePrim(next_free_path(stage, path), "Xform")
    prim.GetReferences().AddReference(assets.resolve_object(url))
    return prim
