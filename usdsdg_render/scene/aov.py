"""The table of AOVs: what each value is, and what stands for nothing."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from usdsdg.errors import RenderError
from usdsdg_render.scene.scene import NO_INSTANCE


@dataclass(frozen=True)
class Aov:
    """One output of the label pass, shape (height, width, *channels)."""

    dtype: type
    channels: tuple[int, ...]
    nothing: float  # value where the ray meets nothing
    meaning: str


AOVS = {
    "instance": Aov(np.int32, (), NO_INSTANCE, "index into WarpRenderer.gprims"),
    "prim": Aov(np.int32, (), -1, "face of the source mesh; of shapes that are no mesh, of the mesh drawn for them"),
    "barycentrics": Aov(np.float32, (3,), 0.0, "weights of the corners of the triangle, which sum to 1"),
    "uv": Aov(np.float32, (2,), 0.0, "texture coordinates of the surface, before any transform of a texture"),
    "distance_to_camera": Aov(np.float32, (), np.inf, "distance from the camera's centre [m]"),
    "distance_to_image_plane": Aov(np.float32, (), np.inf, "distance along the optical axis [m]"),
    "normals": Aov(np.float32, (3,), 0.0, "interpolated normal in the world, towards the camera"),
    "position": Aov(np.float32, (3,), 0.0, "point in the world [stage units]"),
    "bump_normals": Aov(np.float32, (3,), 0.0, "normals after the material's normal map"),
    "albedo": Aov(np.float32, (3,), 0.0, "base colour, linear Rec.709"),
    "diffuse": Aov(np.float32, (3,), 0.0, "base colour of what is not metal, linear Rec.709"),
    "specular": Aov(np.float32, (3,), 0.0, "reflectance at normal incidence, linear Rec.709"),
    "roughness": Aov(np.float32, (), 0.0, "from 0, a mirror, to 1"),
    "emission": Aov(np.float32, (3,), 0.0, "light that the surface gives [nits], linear Rec.709"),
    "transmission": Aov(np.float32, (3,), 0.0, "share of light that glass lets through, linear Rec.709"),
    "ambient_occlusion": Aov(np.float32, (), 1.0, "how open the surface is within AMBIENT_REACH, 1 = wholly"),
    "motion_vectors": Aov(np.float32, (2,), 0.0, "pixels since this camera last looked: +x moved left, +y moved up"),
}


# Those that read all textures of a material.
MATERIAL_AOVS = frozenset({"bump_normals", "diffuse", "specular", "roughness", "emission", "transmission"})
AMBIENT_REACH = 0.35  # [m], as the reference's default


def check_names(names: Collection[str]) -> tuple[str, ...]:
    """The names in the order of the table.

    Raises:
        RenderError: a name is not in the table.
    """
    unknown = sorted(set(names) - AOVS.keys())
    if unknown:
        raise RenderError(f"no such AOV: {', '.join(unknown)}. There are: {', '.join(AOVS)}.")
    return tuple(name for name in AOVS if name in names)
