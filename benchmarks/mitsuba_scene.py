"""The benchmark scene in Mitsuba 3: principled materials, shape groups for meshes that several objects share."""

from __future__ import annotations

import sys
from collections import Counter
from typing import Any

import numpy as np

from benchmarks.path_tracers import SURFACES, View
from benchmarks.scene_meshes import WeldedMesh, material_of, scale_and_rotation, transformed, turned_sky, welded
from usdsdg_render.scene.scene import Scene
from usdsdg_render.scene.structs import LIGHT_DISTANT, LIGHT_SPHERE

# The fast variant needs a shared library of LLVM; the other one needs nothing.
VARIANTS = ("llvm_ad_rgb", "scalar_rgb")


class Mitsuba:
    """A `PathTracer`."""

    def __init__(self, scene: Scene, *, threads: int) -> None:
        import mitsuba as mi

        self._mi = mi
        self.name = f"Mitsuba {mi.__version__} {_choose_variant(mi)}"
        if mi.variant().startswith("llvm"):
            import drjit

            drjit.set_thread_count(threads)
        integrator = {"type": "path", "max_depth": SURFACES + 1, "rr_depth": 1000}
        self._scene = mi.load_dict(
            {"type": "scene", "integrator": integrator, **self._objects(scene), **self._lights(scene)}
        )

    def render(self, view: View, samples: int, seed: int) -> np.ndarray:
        image = self._mi.render(self._scene, sensor=self._sensor(view, samples), spp=samples, seed=seed)
        return np.array(image, np.float32)

    def _sensor(self, view: View, samples: int) -> Any:
        mi = self._mi
        _, up, back, eye = view.local_to_world[:, :3]
        film = {"type": "hdrfilm", "width": view.width, "height": view.height, "pixel_format": "rgb"}
        film["rfilter"] = {"type": "box"}
        return mi.load_dict(
            {
                "type": "perspective",
                "fov_axis": "x",
                "fov": float(np.degrees(2 * np.arctan(view.horizontal_aperture / 2 / view.focal_length))),
                "near_clip": view.clipping_range[0],
                "to_world": mi.ScalarTransform4f().look_at(
                    origin=eye.tolist(), target=(eye - back).tolist(), up=up.tolist()
                ),
                "film": film,
                # In the same time it has half the variance of independent samples, the default.
                "sampler": {"type": "multijitter", "sample_count": samples},
            }
        )

    def _objects(self, scene: Scene) -> dict[str, Any]:
        """Return objects: meshes where prototype and material are used once, else instances."""
        mi, instances, made = self._mi, scene.instances, {}
        meshes = [welded(prototype) for prototype in scene.prototypes]
        kinds = [(int(which), material_of(scene, k)) for k, which in enumerate(instances.prototype)]
        count = Counter(kinds)
        for kind, number in count.items():
            if number > 1:
                made["group_{}_{}".format(*kind)] = {"type": "shapegroup", "mesh": self._mesh(scene, meshes, kind)}
        for k, (kind, matrix) in enumerate(zip(kinds, instances.local_to_world, strict=True)):
            if count[kind] == 1:
                made[f"object_{k}"] = self._mesh(scene, meshes, kind, matrix)
            else:
                group = {"type": "ref", "id": "group_{}_{}".format(*kind)}
                to_world = mi.ScalarTransform4f(matrix.T)
                made[f"object_{k}"] = {"type": "instance", "group": group, "to_world": to_world}
        return made

    def _mesh(self, scene: Scene, meshes: list[WeldedMesh], kind: tuple[int, int], matrix=None) -> Any:
        mi, mesh = self._mi, meshes[kind[0]]
        points, normals = mesh.points, mesh.normals
        if matrix is not None:
            points, normals = transformed(points, matrix), normals @ scale_and_rotation(matrix)[1].T
        properties = mi.Properties()
        properties["bsdf"] = mi.load_dict(self._material(scene, kind[1]))
        made = mi.Mesh(
            "mesh",
            len(points),
            len(mesh.triangles),
            props=properties,
            has_vertex_normals=True,
            has_vertex_texcoords=True,
        )
        parameters = mi.traverse(made)
        parameters["vertex_positions"] = points.ravel()
        parameters["vertex_normals"] = normals.astype(np.float32).ravel()
        parameters["vertex_texcoords"] = mesh.uvs.ravel()
        parameters["faces"] = mesh.triangles.astype(np.uint32).ravel()
        parameters.update()
        return made

    def _material(self, scene: Scene, index: int) -> dict[str, Any]:
        row = scene.materials[index]
        color: dict[str, Any] = {"type": "rgb", "value": row["base_color"].tolist()}
        if row["base_color_texture"] >= 0:
            texels = np.ascontiguousarray(scene.textures[row["base_color_texture"]].texels[::-1, :, :3])
            color = {"type": "bitmap", "bitmap": self._mi.Bitmap(texels), "raw": False}
        # A reflectance of 4 % at normal incidence is "specular" 0.5.
        return {
            "type": "principled",
            "base_color": color,
            "roughness": float(row["roughness"]),
            "metallic": float(row["metallic"]),
            "specular": float(row["specular"][0]) / 0.08,
        }

    def _lights(self, scene: Scene) -> dict[str, Any]:
        mi, made = self._mi, {}
        for k, row in enumerate(scene.lights):
            radiance = {"type": "rgb", "value": row["radiance"].tolist()}
            if row["kind"] == LIGHT_SPHERE:
                emitter = {"type": "area", "radiance": radiance}
                sphere = {"type": "sphere", "center": row["position"].tolist(), "radius": float(row["radius"])}
                made[f"light_{k}"] = {**sphere, "emitter": emitter}
            elif row["kind"] == LIGHT_DISTANT:
                direction = (-row["z_axis"]).tolist()
                made[f"light_{k}"] = {"type": "directional", "direction": direction, "irradiance": radiance}
        # Mitsuba's pole is +y, ours +z.
        to_world = np.eye(4)
        to_world[:3, :3] = [[0, 0, 1], [1, 0, 0], [0, 1, 0]]
        sky = mi.Bitmap(turned_sky(scene.dome.radiance))
        made["sky"] = {"type": "envmap", "bitmap": sky, "to_world": mi.ScalarTransform4f(to_world)}
        return made


def _choose_variant(mi: Any) -> str:
    """Set and return the first variant that can be loaded."""
    for variant in VARIANTS[:-1]:
        try:
            mi.set_variant(variant)
        except ImportError as error:
            print(f"Mitsuba's {variant} cannot be loaded, so {VARIANTS[-1]} is measured: {error}", file=sys.stderr)
        else:
            return variant
    mi.set_variant(VARIANTS[-1])
    return VARIANTS[-1]
