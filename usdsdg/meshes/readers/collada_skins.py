"""Skinned meshes of COLLADA, which trimesh leaves out: made into plain ones in the pose of the file."""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET
from collections.abc import Iterator

import numpy as np


def pose_skins(root: ET.Element, space: str) -> list[str] | None:
    """Replace the instances of controllers by those of plain meshes; return notes, None where there are none.

    space: of the names of elements, such as "{http://www.collada.org/2005/11/COLLADASchema}".
    """
    document = _Document(root, space)
    notes = []
    nodes = [node for node in root.iter(f"{space}node") if node.find(f"{space}instance_controller") is not None]
    for node in nodes:
        for instance in node.findall(f"{space}instance_controller"):
            node.remove(instance)
            try:
                notes += document.place(instance, node)
            except (AttributeError, KeyError, IndexError, ValueError, StopIteration):
                name = node.get("name") or node.get("id") or instance.get("url", "")
                notes.append(f"the skinned mesh {name} is damaged, so it is left out")
    for library in root.findall(f"{space}library_controllers") if nodes else ():
        root.remove(library)  # nothing refers to it any more
    return notes if nodes else None


class _Document:
    """The elements of a file by their ids, and the matrices of its nodes."""

    def __init__(self, root: ET.Element, space: str) -> None:
        self._space = space
        self._root = root
        self._by_id = {str(each.get("id")): each for each in root.iter() if each.get("id")}
        self._parents = {child: parent for parent in root.iter() for child in parent}
        self._count = 0

    def place(self, instance: ET.Element, node: ET.Element) -> Iterator[str]:
        """Add what an instance of a controller shows; yield what is left out of it."""
        controller = self._by_id[instance.get("url", "")[1:]]
        skin = controller.find(self._name("skin"))
        if skin is None:
            yield "morph targets are left out"
            self._add(instance, node, self._geometry(controller))
            return
        geometry = copy.deepcopy(self._geometry(controller))
        geometry.set("id", f"{geometry.get('id')}-posed-{self._count}")
        self._count += 1
        self._pose(geometry, skin, instance)
        next(self._root.iter(self._name("library_geometries"))).append(geometry)
        scene = next(self._root.iter(self._name("visual_scene")))
        names = {key: value for key, value in node.attrib.items() if key == "name"}
        self._add(
            instance, ET.SubElement(scene, self._name("node"), {"id": f"{geometry.get('id')}-node", **names}), geometry
        )
        yield "the skeleton is left out; the object has the pose of the file"

    def _geometry(self, controller: ET.Element) -> ET.Element:
        """Return the mesh of a controller, behind other controllers."""
        for _ in range(8):
            [held] = [each for each in controller if each.tag in (self._name("skin"), self._name("morph"))]
            found = self._by_id[held.get("source", "")[1:]]
            if found.tag == self._name("geometry"):
                return found
            controller = found
        raise ValueError("controllers refer to each other")

    def _add(self, instance: ET.Element, node: ET.Element, geometry: ET.Element) -> None:
        shown = ET.SubElement(node, self._name("instance_geometry"), {"url": f"#{geometry.get('id')}"})
        shown.extend(instance.findall(self._name("bind_material")))

    def _pose(self, geometry: ET.Element, skin: ET.Element, instance: ET.Element) -> None:
        """Move the points of a mesh to where the joints have them."""
        mesh = geometry.find(self._name("mesh"))
        assert mesh is not None
        places = next(
            each
            for vertices in mesh.findall(self._name("vertices"))
            for each in vertices.findall(self._name("input"))
            if each.get("semantic") == "POSITION"
        )
        source = next(
            each for each in mesh.findall(self._name("source")) if each.get("id") == places.get("source", "")[1:]
        )
        points = self._rows(source)[:, :3]
        joints, weights, matrices = self._bound(skin, instance, len(points))
        shape = skin.findtext(self._name("bind_shape_matrix"))
        bind = np.eye(4) if shape is None else np.array(shape.split(), float).reshape(4, 4)
        whole = np.c_[points, np.ones(len(points))] @ bind.T
        total = weights.sum(axis=1, keepdims=True)
        weights = np.where(total > 0.0, weights, 1.0) / np.where(total > 0.0, total, weights.shape[1])
        # A joint of -1 stands for the place of the mesh itself, as the last matrix does.
        blended = np.einsum("nk,nkij->nij", weights, np.concatenate([matrices, [np.eye(4)]])[joints])
        self._set_rows(source, np.einsum("nij,nj->ni", blended, whole)[:, :3])
        # Normals are of the rest; others are made of the triangles. The place of their indices stays.
        for each in mesh.iter(self._name("input")):
            if each.get("semantic") == "NORMAL":
                each.set("semantic", "TEXBINORMAL")

    def _bound(self, skin: ET.Element, instance: ET.Element, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the joints (N, K) and weights (N, K) of the points, and what the joints move these by (J, 4, 4)."""
        inputs = {each.get("semantic"): each for each in skin.findall(f"{self._name('joints')}/{self._name('input')}")}
        names = self._words(self._by_id[inputs["JOINT"].get("source", "")[1:]])
        inverse = self._rows(self._by_id[inputs["INV_BIND_MATRIX"].get("source", "")[1:]]).reshape(-1, 4, 4)
        roots = [self._by_id[(each.text or "").strip()[1:]] for each in instance.findall(self._name("skeleton"))]
        matrices = np.stack([self._world(self._joint(name, roots)) @ bind for name, bind in zip(names, inverse)])
        given = skin.find(self._name("vertex_weights"))
        assert given is not None
        places = {each.get("semantic"): each for each in given.findall(self._name("input"))}
        values = self._rows(self._by_id[places["WEIGHT"].get("source", "")[1:]])[:, 0]
        offsets = {name: int(each.get("offset", 0)) for name, each in places.items()}
        counts = np.array((given.findtext(self._name("vcount")) or "").split(), int)
        pairs = np.array((given.findtext(self._name("v")) or "").split(), int).reshape(-1, max(offsets.values()) + 1)
        if len(counts) != count:
            raise ValueError("there are not as many weights as points")
        vertex = np.repeat(np.arange(count), counts)
        column = np.arange(len(vertex)) - np.repeat(np.cumsum(counts) - counts, counts)
        joints, weights = np.full((count, counts.max(initial=1)), -1), np.zeros((count, counts.max(initial=1)))
        joints[vertex, column] = pairs[:, offsets["JOINT"]]
        weights[vertex, column] = values[pairs[:, offsets["WEIGHT"]]]
        return joints, weights, matrices

    def _joint(self, name: str, roots: list[ET.Element]) -> ET.Element:
        """Return the node that is a joint: by its sid below the skeleton, or by its id."""
        below = [node for root in (*roots, self._root) for node in root.iter(self._name("node"))]
        found = next((node for node in below if node.get("sid") == name), None)
        return self._by_id[name] if found is None else found

    def _world(self, node: ET.Element) -> np.ndarray:
        """Return the matrix from a node to the world, for column vectors."""
        matrix = np.eye(4)
        current: ET.Element | None = node
        while current is not None and current.tag == self._name("node"):
            matrix = self._local(current) @ matrix
            current = self._parents.get(current)
        return matrix

    def _local(self, node: ET.Element) -> np.ndarray:
        matrix = np.eye(4)
        for each in node:
            kind = each.tag.removeprefix(self._space)
            if kind not in ("matrix", "translate", "rotate", "scale"):
                continue
            values, step = np.array((each.text or "").split(), float), np.eye(4)
            if kind == "matrix":
                step = values.reshape(4, 4)
            elif kind == "translate":
                step[:3, 3] = values
            elif kind == "scale":
                step[:3, :3] = np.diag(values)
            else:
                step[:3, :3] = _rotation(values[:3], np.radians(values[3]))
            matrix = matrix @ step
        return matrix

    def _words(self, source: ET.Element) -> list[str]:
        found = [each for each in source if each.tag in (self._name("Name_array"), self._name("IDREF_array"))]
        return (found[0].text or "").split()

    def _rows(self, source: ET.Element) -> np.ndarray:
        values = np.array((source.findtext(self._name("float_array")) or "").split(), float)
        accessor = source.find(f"{self._name('technique_common')}/{self._name('accessor')}")
        return values.reshape(-1, int(accessor.get("stride", 1)) if accessor is not None else 1)

    def _set_rows(self, source: ET.Element, rows: np.ndarray) -> None:
        array = source.find(self._name("float_array"))
        accessor = source.find(f"{self._name('technique_common')}/{self._name('accessor')}")
        assert array is not None
        assert accessor is not None
        array.text = " ".join(map(repr, rows.ravel().tolist()))
        array.set("count", str(rows.size))
        accessor.set("stride", str(rows.shape[1]))
        for extra in accessor.findall(self._name("param"))[rows.shape[1] :]:
            accessor.remove(extra)

    def _name(self, kind: str) -> str:
        return self._space + kind


def _rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Return the rotation (3, 3) about an axis (Rodrigues)."""
    length = float(np.linalg.norm(axis))
    if length == 0.0:
        return np.eye(3)
    x, y, z = axis / length
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * across + (1.0 - np.cos(angle)) * across @ across
