"""The benchmark scene in Newton's SensorCamera: its own spheres and boxes, textured meshes, one light with shadows."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from scipy.spatial.transform import Rotation

from benchmarks.scene_meshes import material_of, scale_and_rotation, welded
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg_render.scene.scene import Scene


class SensorCameras:
    """Color with texture and shadow, distance, normals and ids of all views in one call.

    `order` names the order in which its threads process pixels; empty for Newton's default.
    """

    def __init__(self, scene: Scene, views: list[CameraView], device: str = "cpu", order: str = "") -> None:
        import newton
        from newton.sensors import SensorCamera

        model = _model(newton, scene, device)
        self._state = model.state()
        self._sensor = SensorCamera(model)
        self._sensor.create_default_light(enable_shadows=True)
        self._config = SensorCamera.RenderConfig(
            enable_textures=True, enable_shadows=True, enable_backface_culling=False
        )
        if order:
            self._config.render_order = SensorCamera.RenderOrder[order]
        view, count = views[0], len(views)
        size = (count, view.width, view.height)
        self._rays = SensorCamera.compute_camera_rays_pinhole(
            view.width,
            view.height,
            focal_length=view.focal_length,
            horizontal_aperture=view.horizontal_aperture,
            vertical_aperture=view.horizontal_aperture * view.height / view.width,
            device=device,
        )
        poses = [_pose(each.local_to_world) for each in views]
        self._poses = wp.array(poses, dtype=wp.transformf, device=device)
        self._worlds = wp.zeros(count, dtype=wp.int32, device=device)
        self._images = {
            "color_image": self._sensor.allocate_image_color(*size),
            "depth_image": self._sensor.allocate_image_depth(*size),
            "normal_image": self._sensor.allocate_image_normal(*size),
            "shape_index_image": self._sensor.allocate_image_shape_index(*size),
        }

    def render(self) -> np.ndarray:
        """Render all images; return the distances (views, H, W) float32, not positive where nothing is hit."""
        self.draw()
        return self._images["depth_image"].numpy()

    def draw(self) -> None:
        """Render all images, on the device."""
        self._sensor.update(
            self._state,
            self._poses,
            self._rays,
            render_config=self._config,
            world_indices=self._worlds,
            **self._images,
        )


def _model(newton: Any, scene: Scene, device: str) -> Any:
    builder = newton.ModelBuilder()
    meshes = {}
    for k, which in enumerate(scene.instances.prototype):
        prototype, row = scene.prototypes[which], scene.materials[material_of(scene, k)]
        matrix = scene.instances.local_to_world[k]
        scale = scale_and_rotation(matrix)[0]
        body = builder.add_body(xform=_pose(matrix))
        color = tuple(row["base_color"].tolist())
        if prototype.name == "/ball":
            builder.add_shape_sphere(body, radius=scale, color=color)
        elif prototype.name == "/box":
            builder.add_shape_box(body, hx=scale, hy=scale, hz=scale, color=color)
        else:
            if which not in meshes:
                texels = scene.textures[row["base_color_texture"]].texels[..., :3]
                meshes[which] = _mesh(newton, welded(prototype), np.ascontiguousarray(texels))
            builder.add_shape_mesh(body, mesh=meshes[which], scale=wp.vec3(scale))
    return builder.finalize(device=device)


def _mesh(newton: Any, mesh: Any, texels: np.ndarray) -> Any:
    return newton.Mesh(
        mesh.points,
        mesh.triangles.ravel(),
        normals=mesh.normals,
        uvs=mesh.uvs,
        texture=texels,
        compute_inertia=False,
    )


def _pose(matrix: np.ndarray) -> wp.transform:
    """Return the pose of a row-vector matrix, without its scale."""
    rotation = scale_and_rotation(matrix)[1]
    return wp.transform(wp.vec3(*matrix[3, :3]), wp.quat(*Rotation.from_matrix(rotation).as_quat()))
