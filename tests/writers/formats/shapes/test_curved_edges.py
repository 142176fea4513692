"""Edges of boxes through lenses, against points that lie close together on them."""

from __future__ import annotations

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom

import usdsdg as rep
from usdsdg.writers.formats.shapes.camera_projection import edge_pixels, project

SIZE = (640, 320)
# A long edge beside the camera, one above it, which a panorama draws past its pole, and one straight ahead.
EDGES = np.array([[[-3, -1, -9], [-3, -1, 9]], [[-4, 1, -0.2], [4, 1, -0.2]], [[-1, 0.5, -20], [1, 0.5, -20]]], float)


def parameters(model):
    stage = rep.get_stage()
    UsdGeom.Cube.Define(stage, "/World/cube")
    camera = UsdGeom.Camera.Define(stage, "/World/camera")
    camera.GetPrim().CreateAttribute("cameraProjectionType", Sdf.ValueTypeNames.Token).Set(model)
    camera.AddTranslateOp().Set(Gf.Vec3d(0, 0, 5))
    annotator = rep.AnnotatorRegistry.get_annotator("camera_params")
    annotator.attach(rep.create.render_product("/World/camera", SIZE))
    rep.create.light(light_type="dome")
    rep.orchestrator.step()
    return annotator.get_data()


def beside(points, segments):
    """Return how far each point (N, 2) is from the nearest of segments (M, 2, 2)."""
    start, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    length = np.maximum((along**2).sum(axis=1), 1e-12)
    part = np.clip(((points[:, None] - start) * along).sum(axis=2) / length, 0, 1)
    return np.linalg.norm(points[:, None] - start - part[..., None] * along, axis=2).min(axis=1)


@pytest.mark.parametrize("model", ["fisheyePolynomial", "fisheyeSpherical"])
def test_edges_follow_the_lens_with_pieces_where_it_bends_them(stage, model):
    params = parameters(model)
    found = edge_pixels(EDGES, params)
    for edge, pieces in zip(EDGES, found, strict=True):
        dense = project(edge[0] + np.linspace(0, 1, 4001)[:, None] * (edge[1] - edge[0]), params)
        # Away from the seam of a panorama, across which no piece is drawn.
        inside = (dense[:, 0] > 3) & (dense[:, 0] < SIZE[0] - 3)
        assert inside.sum() > 1000
        assert beside(dense[inside], pieces).max() < 0.5
    assert len(found[2]) == 32
    assert max(map(len, found)) > 32
