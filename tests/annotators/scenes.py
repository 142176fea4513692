"""Scenes that tests of annotators and writers share."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st
from pxr import Gf, Usd, UsdGeom

from tests.annotators.ray_caster import add_cube, add_sphere, new_stage
from usdsdg.stage.poses.look_at import look_at_matrix


def street() -> Usd.Stage:
    """From above: two apples, one half under a pear; a hidden cube below it; one beside the picture; bare ground."""
    stage = new_stage()
    add_cube(stage, "/World/Ground", scale=(6, 4, 0.1), translate=(0, 0, -3))
    add_sphere(stage, "/World/Apple1", "Apple", translate=(-1.5, 0, 0))
    add_sphere(stage, "/World/Apple2", "Apple", translate=(1.2, 0, 0))
    add_cube(stage, "/World/Pear", "Pear", translate=(1.6, 0.2, 1.5), rotate=(20, 30, 40))
    add_cube(stage, "/World/Hidden", "Secret", translate=(1.7, 0.2, 0.2), scale=(0.1, 0.1, 0.1))
    add_cube(stage, "/World/Outside", "Far", translate=(30, 0, 0))
    return stage


def add_camera(stage: Usd.Stage, path: str, eye, target, *, near: float = 0.1) -> str:
    camera = UsdGeom.Camera.Define(stage, path)
    camera.CreateFocalLengthAttr(24.0)
    camera.CreateHorizontalApertureAttr(20.955)
    camera.CreateClippingRangeAttr(Gf.Vec2f(near, 1000.0))
    UsdGeom.Xformable(camera).AddTransformOp().Set(look_at_matrix(eye, target, up=(0, 0, 1)))
    return path


angles = st.floats(-180, 180)
poses = st.fixed_dictionaries(
    {
        "translate": st.tuples(st.floats(-2, 2), st.floats(-1.5, 1.5), st.floats(-2, 2)),
        "rotate": st.tuples(angles, angles, angles),
        "scale": st.tuples(*[st.floats(0.2, 1.5)] * 3),
    }
)


@st.composite
def crowds(draw) -> Usd.Stage:
    """A stage with a few labeled cubes and spheres around the origin."""
    stage = new_stage()
    for index, pose in enumerate(draw(st.lists(poses, min_size=1, max_size=5))):
        add = draw(st.sampled_from([add_cube, add_sphere]))
        label = draw(st.sampled_from(["apple", "pear", None]))
        add(stage, f"/World/Thing{index}", label, **pose)
    return stage


def mask_of(frame, prim_path: str) -> np.ndarray:
    """(H, W) where the gprim `prim_path` is seen."""
    return frame.aovs["instance"] == frame.gprims.index(prim_path)
