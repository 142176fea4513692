"""The benchmark scene in Blender's Cycles, by way of bpy: principled materials, objects that share their meshes."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.path_tracers import SURFACES, View
from benchmarks.scene_meshes import is_flat, material_of, turned_sky
from usdsdg_render.scene.scene import Prototype, Scene
from usdsdg_render.scene.structs import LIGHT_DISTANT, LIGHT_SPHERE


class Cycles:
    """A `PathTracer`. The time of an image includes the scene's transfer, which is little beside 64 samples."""

    def __init__(self, scene: Scene, *, threads: int) -> None:
        import bpy

        self._bpy = bpy
        self.name = f"Cycles of bpy {bpy.app.version_string}"
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self._target = bpy.context.scene
        self._folder = tempfile.TemporaryDirectory()
        materials = [self._material(scene, k) for k in range(len(scene.materials))]
        meshes = [self._mesh(prototype, materials[0]) for prototype in scene.prototypes]
        for k, which in enumerate(scene.instances.prototype):
            each = self._add(f"object_{k}", meshes[which], scene.instances.local_to_world[k])
            each.material_slots[0].link = "OBJECT"
            each.material_slots[0].material = materials[material_of(scene, k)]
        for k, row in enumerate(scene.lights):
            self._add_light(f"light_{k}", row)
        self._add_sky(scene.dome.radiance)
        self._configure(threads)

    def render(self, view: View, samples: int, seed: int) -> np.ndarray:
        bpy, target = self._bpy, self._target
        self._set_camera(view)
        target.cycles.samples, target.cycles.seed = samples, seed
        target.render.filepath = str(Path(self._folder.name) / "image.exr")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(target.render.filepath)
        pixels = np.empty(view.width * view.height * image.channels, np.float32)
        image.pixels.foreach_get(pixels)
        channels = image.channels
        bpy.data.images.remove(image)
        return pixels.reshape(view.height, view.width, channels)[::-1, :, :3].copy()

    def _set_camera(self, view: View) -> None:
        bpy, target = self._bpy, self._target
        lens = bpy.data.cameras.get("camera")
        if lens is None:
            lens = bpy.data.cameras.new("camera")
            target.camera = self._add("camera", lens, np.eye(4))
        lens.sensor_fit, lens.sensor_width, lens.lens = "HORIZONTAL", view.horizontal_aperture, view.focal_length
        lens.clip_start, lens.clip_end = view.clipping_range
        target.camera.matrix_world = _matrix(view.local_to_world)
        target.render.resolution_x, target.render.resolution_y = view.width, view.height

    def _add(self, name: str, data: Any, local_to_world: np.ndarray) -> Any:
        added = self._bpy.data.objects.new(name, data)
        added.matrix_world = _matrix(local_to_world)
        self._target.collection.objects.link(added)
        return added

    def _mesh(self, prototype: Prototype, material: Any) -> Any:
        mesh = self._bpy.data.meshes.new(prototype.name)
        mesh.from_pydata(prototype.points.tolist(), [], prototype.triangles.tolist())
        if not is_flat(prototype):
            mesh.shade_smooth()
        mesh.uv_layers.new().data.foreach_set("uv", prototype.uvs.ravel())
        # A slot, which each object fills with a material of its own.
        mesh.materials.append(material)
        return mesh

    def _material(self, scene: Scene, index: int) -> Any:
        row = scene.materials[index]
        material = self._bpy.data.materials.new(f"material_{index}")
        material.use_nodes = True
        nodes, links = material.node_tree.nodes, material.node_tree.links
        surface = nodes["Principled BSDF"].inputs
        surface["Base Color"].default_value = (*row["base_color"].tolist(), 1.0)
        surface["Roughness"].default_value = float(row["roughness"])
        surface["Metallic"].default_value = float(row["metallic"])
        surface["IOR"].default_value = 1.5
        surface["Specular IOR Level"].default_value = float(row["specular"][0]) / 0.08
        if row["base_color_texture"] >= 0:
            texels = scene.textures[row["base_color_texture"]].texels[::-1] / np.float32(255)
            texture = nodes.new("ShaderNodeTexImage")
            texture.image = self._image(f"texture_{index}", texels)
            links.new(texture.outputs["Color"], surface["Base Color"])
        return material

    def _image(self, name: str, pixels: np.ndarray, *, linear: bool = False) -> Any:
        """An image of (H, W, 4) float32 with its lowest row first."""
        height, width = pixels.shape[:2]
        image = self._bpy.data.images.new(name, width, height, float_buffer=linear)
        if linear:
            image.colorspace_settings.name = "Linear Rec.709"
        image.pixels.foreach_set(np.ascontiguousarray(pixels, np.float32).ravel())
        image.update()
        image.pack()
        return image

    def _add_light(self, name: str, row: np.ndarray) -> None:
        brightest = float(row["radiance"].max())
        color = (row["radiance"] / brightest).tolist()
        matrix = np.eye(4)
        if row["kind"] == LIGHT_SPHERE:
            light = self._bpy.data.lights.new(name, "POINT")
            radius = float(row["radius"])
            # Its energy is the flux of an isotropic point; a sphere of radiance L emits 4 pi^2 r^2 L.
            light.energy, light.shadow_soft_size = brightest * 4 * np.pi**2 * radius**2, radius
            light.use_soft_falloff = False
            matrix[3, :3] = row["position"]
        elif row["kind"] == LIGHT_DISTANT:
            light = self._bpy.data.lights.new(name, "SUN")
            light.energy, light.angle = brightest, 0.0
            matrix[:3, :3] = row["x_axis"], row["y_axis"], row["z_axis"]
        else:
            raise ValueError(f"{name}: no light of kind {row['kind']} in the benchmark scene")
        light.color = color
        self._add(name, light, matrix).visible_camera = bool(row["visible"])

    def _add_sky(self, radiance: np.ndarray) -> None:
        world = self._bpy.data.worlds.new("sky")
        world.use_nodes = True
        nodes, links = world.node_tree.nodes, world.node_tree.links
        environment = nodes.new("ShaderNodeTexEnvironment")
        opaque = np.ones((*radiance.shape[:2], 1), np.float32)
        pixels = np.concatenate([turned_sky(radiance), opaque], -1)[::-1]
        environment.image = self._image("sky", pixels, linear=True)
        links.new(environment.outputs["Color"], nodes["Background"].inputs["Color"])
        self._target.world = world

    def _configure(self, threads: int) -> None:
        render, cycles = self._target.render, self._target.cycles
        render.engine = "CYCLES"
        # With one thread alone Cycles keeps another one spinning, which would count as CPU time.
        render.threads_mode, render.threads = "FIXED", max(2, threads)
        render.use_persistent_data = True
        render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
        cycles.device, cycles.use_denoising, cycles.use_adaptive_sampling = "CPU", False, False
        cycles.pixel_filter_type = "BOX"
        cycles.filter_width = 1.0
        # Every kind of bounce may be as long as a path.
        for kind in ("max", "diffuse", "glossy", "transmission"):
            setattr(cycles, f"{kind}_bounces", SURFACES - 1)
        cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
        cycles.blur_glossy = 0.0
        cycles.caustics_reflective = True


def _matrix(local_to_world: np.ndarray) -> Any:
    """Blender's matrix, for column vectors."""
    from mathutils import Matrix

    return Matrix(local_to_world.T.tolist())
