"""Prims of a job that are posed anew for each frame: objects with labels, and distractors without."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pxr import Gf, Sdf, Usd, UsdShade

from usdsdg.scenarios.shared.lighting import show
from usdsdg.scenarios.shared.mesh_folder import MeshAsset
from usdsdg.stage.paths import next_free_path, valid_name
from usdsdg.stage.poses.xform_ops import author_pose
from usdsdg.stage.semantics import labels

# Radius of the sphere around each shape, with the sizes that USD gives it by default.
SHAPE_RADII = {"capsule": 1.0, "cone": 2**0.5, "cylinder": 2**0.5, "sphere": 1.0, "cube": 3**0.5}


@dataclass(frozen=True)
class Body:
    """A prim with the sphere around it, in its own frame with its own scale applied [meters]."""

    prim: Usd.Prim
    center: np.ndarray  # (3,)
    radius: float
    scale: float
    surface: UsdShade.Shader | None = None  # of a shape with a material of its own

    @property
    def can_stretch(self) -> bool:
        """Whether it is a shape, whose proportions mean nothing."""
        return self.surface is not None

    def paint(self, generator: np.random.Generator) -> None:
        """Draw color, roughness and whether it is a metal, of a shape; others keep theirs."""
        if self.surface is not None:
            self.surface.GetInput("diffuseColor").Set(Gf.Vec3f(*(generator.uniform(0.02, 0.95, 3) ** 1.5).tolist()))
            self.surface.GetInput("roughness").Set(float(generator.uniform(0.1, 1.0)))
            self.surface.GetInput("metallic").Set(float(generator.random() < 0.15))

    def show(self, visible: bool) -> None:
        """Show or hide it."""
        show(self.prim, visible)

    def place(
        self, center: np.ndarray, turn: Gf.Quatd, *, size: float = 1.0, stretch: Sequence[float] = (1, 1, 1)
    ) -> None:
        """Put the middle of its bounds at a point of the parent's frame; `size` and `stretch` are factors."""
        matrix = np.array(Gf.Matrix3d(turn)).T  # column vectors
        scale = np.asarray(stretch, np.float64) * size
        author_pose(
            self.prim,
            translate=(center - matrix @ (self.center * scale)).tolist(),
            orient=turn,
            scale=(scale * self.scale).tolist(),
        )


def add_asset(parent: Usd.Prim, asset: MeshAsset, *, labeled: bool) -> Body:
    """Add a prim that refers to an asset: with its class as its only label, or without labels."""
    stage = parent.GetStage()
    prim = stage.DefinePrim(next_free_path(stage, f"{parent.GetPath()}/{valid_name(asset.label)}"), "Xform")
    # Below, so that the pose is not mixed with a transform of the asset's own.
    inner = stage.DefinePrim(prim.GetPath().AppendChild("Asset"), "Xform")
    inner.GetReferences().AddReference(asset.file)
    labels.remove_labels(inner, recursive=True)
    if labeled:
        labels.add_labels(prim, {"class": [asset.label]})
    return Body(prim, asset.center, asset.radius, asset.scale)


def add_shape(parent: Usd.Prim, shape: str) -> Body:
    """Add a basic shape with a material of its own."""
    stage = parent.GetStage()
    prim = stage.DefinePrim(next_free_path(stage, f"{parent.GetPath()}/{shape.capitalize()}"), shape.capitalize())
    material = UsdShade.Material.Define(stage, prim.GetPath().AppendChild("Material"))
    surface = UsdShade.Shader.Define(stage, material.GetPath().AppendChild("Surface"))
    surface.CreateIdAttr("UsdPreviewSurface")
    surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
    surface.CreateInput("roughness", Sdf.ValueTypeNames.Float)
    surface.CreateInput("metallic", Sdf.ValueTypeNames.Float)
    material.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", Sdf.ValueTypeNames.Token))
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)
    return Body(prim, np.zeros(3), SHAPE_RADII[shape], 1.0, surface)
