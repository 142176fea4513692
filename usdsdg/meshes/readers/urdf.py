"""URDF: the rigid look of a robot or object, all links in their zero pose."""

from __future__ import annotations

import importlib.util
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from usdsdg.errors import AssetError, Unsupported
from usdsdg.meshes.model import Material, MeshFile, Part
from usdsdg.meshes.readers import scenes


def read(file: Path) -> MeshFile:
    """Read the visual geometry of a URDF file; joints become rigid.

    Raises:
        Unsupported: the package yourdfpy is not installed.
    """
    if importlib.util.find_spec("yourdfpy") is None:
        raise Unsupported(f"{file}: URDF needs the package yourdfpy; install it with pip install 'usdsdg[meshes]'")
    import yourdfpy

    robot: Any = yourdfpy.URDF.load(str(file), load_meshes=False, build_scene_graph=True, mesh_dir=str(file.parent))
    made = _Made(file, robot)
    for name, link in robot.link_map.items():
        pose = np.asarray(robot.get_transform(name, robot.base_link)).T
        for index, visual in enumerate(link.visuals):
            origin = np.eye(4) if visual.origin is None else np.asarray(visual.origin).T
            made.add(f"{name}_{index}" if index else name, visual, origin @ pose)
    return MeshFile(tuple(made.parts), tuple(made.materials), "Z", 1.0, tuple(made.notes), tuple(made.files))


class _Made:
    """Parts and materials of all links so far."""

    def __init__(self, file: Path, robot: Any) -> None:
        self._file = file
        self._named = {each.name: each for each in robot.robot.materials}
        self.parts: list[Part] = []
        self.materials: list[Material] = []
        self.notes: list[str] = ["joints are rigid, in their zero pose"] if robot.joint_map else []
        self.files: list[str] = []

    def add(self, name: str, visual: Any, matrix: np.ndarray) -> None:
        """Add the geometry of one visual element."""
        geometry, own = visual.geometry, self._material(visual.material)
        if geometry.mesh is not None:
            self._add_mesh(name, geometry.mesh, matrix, own)
            return
        shape = _shape(geometry)
        if shape is None:
            self.notes.append(f"the visual {name} has no geometry that is known")
            return
        points, triangles = np.asarray(shape.vertices, np.float64), np.asarray(shape.faces, np.int64)
        self.parts.append(Part(name, points, triangles, material=own).moved(matrix))

    def _add_mesh(self, name: str, mesh: Any, matrix: np.ndarray, own: int | None) -> None:
        path = self._find(str(mesh.filename))
        if path is None:
            raise AssetError(f"{self._file}: the mesh {mesh.filename} of {name} is not there")
        found = scenes.read(path)
        scale = np.ones(3) if mesh.scale is None else np.broadcast_to(np.asarray(mesh.scale, float), 3)
        matrix = np.diag([*(scale * found.meters_per_unit), 1.0]) @ matrix
        first = len(self.materials)
        self.materials += found.materials
        for part in found.parts:
            index = own if own is not None else (None if part.material is None else first + part.material)
            self.parts.append(replace(part, name=name, material=index).moved(matrix))
        self.notes += found.notes
        self.files += [str(path.resolve()), *found.files]

    def _find(self, name: str) -> Path | None:
        """Return the file of a name such as `package://robot/meshes/arm.stl`, looked up in the folders above too."""
        plain = name.removeprefix("file://")
        inside = plain.removeprefix("package://")
        tails = [inside, inside.partition("/")[2]] if inside != plain else [plain]
        folders = [self._file.parent, *list(self._file.parent.parents)[:4]]
        return next((folder / tail for folder in folders for tail in tails if tail and (folder / tail).is_file()), None)

    def _material(self, given: Any) -> int | None:
        found = self._named.get(given.name, given) if given is not None and given.color is None else given
        if found is None or found.color is None:
            return None
        red, green, blue, alpha = (float(each) for each in found.color.rgba)
        material = Material(str(found.name or "Material"), color=(red, green, blue), opacity=alpha)
        if material not in self.materials:
            self.materials.append(material)
        return self.materials.index(material)


def _shape(geometry: Any) -> Any:
    """Return the mesh of a box, sphere or cylinder; None for others."""
    import trimesh

    if geometry.box is not None:
        return trimesh.creation.box(extents=geometry.box.size)
    if geometry.sphere is not None:
        return trimesh.creation.uv_sphere(radius=geometry.sphere.radius, count=[32, 64])
    if geometry.cylinder is not None:
        return trimesh.creation.cylinder(radius=geometry.cylinder.radius, height=geometry.cylinder.length, sections=64)
    return None
