"""What trimesh does not read of glTF, made into what it does: poses of skeletons, instances, packed numbers, UVs."""

from __future__ import annotations

import copy
import importlib.util
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from usdsdg.errors import Unsupported
from usdsdg.meshes.readers.gltf_document import Document
from usdsdg.meshes.readers.gltf_looks import Look, pictures_left_out, read_looks, take_over_glossiness
from usdsdg.stage.poses.rotations import matrix_from_quat

_DRACO, _INSTANCES, _TRANSFORM = "KHR_draco_mesh_compression", "EXT_mesh_gpu_instancing", "KHR_texture_transform"
# Extensions that a file may require: read, or of the look alone.
_KNOWN = {
    _DRACO, _INSTANCES, _TRANSFORM, "KHR_mesh_quantization", "EXT_texture_webp", "KHR_texture_basisu",
    "KHR_lights_punctual",
}  # fmt: skip
_LOOKS = ("KHR_materials_", "KHR_technique")
_FAN = 6


def prepared(file: Path, beside: Callable[[str], bytes]) -> tuple[bytes, list[str], list[Look]]:
    """Return a file as the bytes of a GLB file that trimesh reads in full, notes of what is left out, and materials.

    Raises:
        AssetUnreadable: it is damaged. Unsupported: it requires an extension that is not read.
    """
    document = Document(file, beside)
    model = document.json
    _check_extensions(file, model)
    notes = [*_left_out(model), *pictures_left_out(document, beside)]
    for primitive in _primitives(model):
        if _DRACO in primitive.get("extensions", {}):
            _decompress(document, primitive)
    _choose_scene(model)
    take_over_glossiness(document)
    _pose_skins(document)
    _place_instances(document)
    for primitive in _primitives(model):
        notes += _choose_uvs(document, primitive)
        notes += _clear_points(document, primitive)
        _unpack(document, primitive)
    _part_meshes(model)
    looks, lost = read_looks(document)
    return document.glb(), list(dict.fromkeys([*notes, *lost])), looks


def _check_extensions(file: Path, model: dict[str, Any]) -> None:
    required = [each for each in model.get("extensionsRequired", []) if not each.startswith(_LOOKS)]
    unknown = [each for each in required if each not in _KNOWN]
    if unknown:
        names = " and ".join(unknown)
        raise Unsupported(f"{file} needs the glTF extension {names}, which is not read; export it without")
    compressed = any(_DRACO in primitive.get("extensions", {}) for primitive in _primitives(model))
    if compressed and importlib.util.find_spec("DracoPy") is None:
        raise Unsupported(
            f"{file} is compressed with {_DRACO}, which needs the package DracoPy; install it with "
            "pip install DracoPy, or export the file without compression"
        )


def _left_out(model: dict[str, Any]) -> Iterator[str]:
    for name in model.get("extensionsRequired", []):
        if name.startswith("KHR_technique"):
            yield f"what materials have by {name} is left out"
    if model.get("skins"):
        yield "the skeleton is left out; the object has the pose of the file"
    if model.get("animations"):
        yield "animations are left out"
    if any(primitive.get("targets") for primitive in _primitives(model)):
        yield "morph targets are left out"
    if model.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights"):
        yield "lights are left out"
    if model.get("cameras"):
        yield "cameras are left out"
    if "KHR_materials_variants" in model.get("extensions", {}):
        yield "variants of materials are left out; the first ones are used"


def _primitives(model: dict[str, Any]) -> Iterator[dict[str, Any]]:
    for mesh in model.get("meshes", []):
        yield from mesh.get("primitives", [])


def _decompress(document: Document, primitive: dict[str, Any]) -> None:
    """Replace what Draco holds of a primitive by plain arrays, in the numbers that its accessors announce."""
    import DracoPy  # pyright: ignore[reportMissingImports]

    given, attributes = primitive["extensions"].pop(_DRACO), primitive.get("attributes", {})
    decoded = DracoPy.decode(document.bytes_of_view(given["bufferView"]))
    found = {each["unique_id"]: np.asarray(each["data"]) for each in decoded.attributes}
    for name in given["attributes"].keys() & attributes.keys():
        values = document.normalized(found[given["attributes"][name]], attributes[name])
        is_count = name.startswith("JOINTS")
        attributes[name] = document.add(values.astype(np.uint32 if is_count else np.float32))
    triangles = np.asarray(decoded.faces, np.uint32).reshape(-1, 1)
    primitive.update(mode=4, indices=document.add(triangles))


def _unpack(document: Document, primitive: dict[str, Any]) -> None:
    """Replace packed and sparse numbers by plain ones, and fans by triangles."""
    attributes = primitive.get("attributes", {})
    for name in ("POSITION", "NORMAL", "TEXCOORD_0", "COLOR_0"):  # of 16-bit colors trimesh drops the upper byte
        if name in attributes:
            entry = document.json["accessors"][attributes[name]]
            if "sparse" in entry or entry["componentType"] != 5126:
                attributes[name] = document.add(document.floats(attributes[name]))
    if primitive.get("mode") == _FAN and "POSITION" in attributes:
        count = document.json["accessors"][attributes["POSITION"]]["count"]
        corners = document.array(primitive["indices"])[:, 0] if "indices" in primitive else np.arange(count)
        middle = np.repeat(corners[:1], max(len(corners) - 2, 0))
        fan = np.stack([middle, corners[1:-1], corners[2:]], axis=1).astype(np.uint32)
        primitive.update(mode=4, indices=document.add(fan.reshape(-1, 1)))


def _choose_uvs(document: Document, primitive: dict[str, Any]) -> Iterator[str]:
    """Let a primitive's first UVs be those that the picture of its color has, with their transform."""
    materials, attributes = document.json.get("materials", []), primitive.get("attributes", {})
    if primitive.get("material") not in range(len(materials)):
        return
    look = materials[primitive["material"]]
    surface = look.get("pbrMetallicRoughness", {})
    used = [surface.get("baseColorTexture"), surface.get("metallicRoughnessTexture")]
    used += [look.get(name) for name in ("normalTexture", "occlusionTexture", "emissiveTexture")]
    wanted = [_uvs_of(each) for each in used if isinstance(each, dict)]
    if not wanted:
        return
    if any(each != wanted[0] for each in wanted):
        name = look.get("name", primitive["material"])
        yield f"the material {name} has several sets of UVs; that of its first picture is used for all"
    number, transform = wanted[0]
    if f"TEXCOORD_{number}" in attributes and (number or transform):
        uvs = document.floats(attributes[f"TEXCOORD_{number}"])
        attributes["TEXCOORD_0"] = document.add(_transformed(uvs, dict(transform)))


def _clear_points(document: Document, primitive: dict[str, Any]) -> Iterator[str]:
    """Say where the colors of points have an opacity that a material uses."""
    materials, index = document.json.get("materials", []), primitive.get("attributes", {}).get("COLOR_0")
    look = materials[primitive["material"]] if primitive.get("material") in range(len(materials)) else {}
    if index is None or look.get("alphaMode", "OPAQUE") == "OPAQUE":
        return
    if document.json["accessors"][index]["type"] == "VEC4":
        values = document.array(index)[:, 3]
        if values.min(initial=1) < (1.0 if values.dtype.kind == "f" else np.iinfo(values.dtype).max):
            yield f"the opacity of the colors of points is left out for the material {look.get('name', 'Material')}"


def _uvs_of(texture: dict[str, Any]) -> tuple[int, tuple[tuple[str, Any], ...]]:
    """Return the set of UVs of a picture and their transform."""
    transform = texture.get("extensions", {}).get(_TRANSFORM, {})
    number = transform.get("texCoord", texture.get("texCoord", 0))
    kept = {name: transform[name] for name in ("offset", "rotation", "scale") if name in transform}
    return number, tuple((name, tuple(np.atleast_1d(value).tolist())) for name, value in sorted(kept.items()))


def _transformed(uvs: np.ndarray, transform: dict[str, tuple[float, ...]]) -> np.ndarray:
    scale, offset = transform.get("scale", (1.0, 1.0)), transform.get("offset", (0.0, 0.0))
    angle = transform.get("rotation", (0.0,))[0]
    cosine, sine = np.cos(angle), np.sin(angle)
    turned = uvs * np.array(scale) @ np.array([[cosine, -sine], [sine, cosine]])
    return (turned + np.array(offset)).astype(np.float32)


def _pose_skins(document: Document) -> None:
    """Move the points of skinned meshes to where their skeletons have them."""
    model = document.json
    nodes = model.get("nodes", [])
    skinned = [node for node in nodes if "skin" in node and "mesh" in node]
    if not skinned:
        return
    to_world = _world_matrices(nodes)
    for node in skinned:
        skin = model["skins"][node.pop("skin")]
        joints = np.stack([to_world[joint] for joint in skin["joints"]])
        if "inverseBindMatrices" in skin:
            inverse = document.array(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
            joints = joints @ inverse[: len(joints)]
        mesh = copy.deepcopy(model["meshes"][node.pop("mesh")])
        for primitive in mesh["primitives"]:
            _pose(document, primitive["attributes"], joints)
        model["meshes"].append(mesh)
        nodes.append({"mesh": len(model["meshes"]) - 1, "name": node.get("name", "skinned")})
        for scene in model.get("scenes", []):
            scene.setdefault("nodes", []).append(len(nodes) - 1)


def _pose(document: Document, attributes: dict[str, int], joints: np.ndarray) -> None:
    if not {"POSITION", "JOINTS_0", "WEIGHTS_0"} <= attributes.keys():
        return
    sets = [k for k in range(len(attributes)) if {f"JOINTS_{k}", f"WEIGHTS_{k}"} <= attributes.keys()]
    weights = np.hstack([document.floats(attributes[f"WEIGHTS_{k}"]).astype(float) for k in sets])
    weights /= np.maximum(weights.sum(axis=1, keepdims=True), 1e-9)
    bound = np.hstack([document.array(attributes[f"JOINTS_{k}"]).astype(int) for k in sets])
    matrices = np.einsum("nk,nkij->nij", weights, joints[bound])
    points = document.floats(attributes["POSITION"]).astype(float)
    moved = np.einsum("nij,nj->ni", matrices[:, :3, :3], points) + matrices[:, :3, 3]
    attributes["POSITION"] = document.add(moved.astype(np.float32))
    if "NORMAL" in attributes:
        normals = document.floats(attributes["NORMAL"]).astype(float)
        turned = np.einsum("nji,nj->ni", np.linalg.pinv(matrices[:, :3, :3]), normals)
        turned /= np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-30)
        attributes["NORMAL"] = document.add(turned.astype(np.float32))


def _choose_scene(model: dict[str, Any]) -> None:
    """Give a library without a scene one of all its nodes; cameras would take their nodes out of it."""
    nodes = model.get("nodes", [])
    for node in nodes:
        node.pop("camera", None)
    if not model.get("scenes"):
        children = {child for node in nodes for child in node.get("children", [])}
        model["scenes"] = [{"nodes": [number for number in range(len(nodes)) if number not in children]}]
        model["scene"] = 0


def _part_meshes(model: dict[str, Any]) -> None:
    """Give each of several primitives of a mesh a node of its own: trimesh would draw their names by lot."""
    nodes, meshes = model.get("nodes", []), model.get("meshes", [])
    parts: dict[int, list[int]] = {}
    for number, mesh in enumerate(list(meshes)):
        if len(mesh.get("primitives", [])) > 1:
            parts[number] = list(range(len(meshes), len(meshes) + len(mesh["primitives"])))
            name = mesh.get("name", f"mesh_{number}")
            meshes += [{"name": f"{name}_{k}", "primitives": [each]} for k, each in enumerate(mesh["primitives"])]
    for number, node in enumerate(list(nodes)):
        if (own := parts.get(node.get("mesh", -1))) is None:
            continue
        name = node.get("name") or meshes[node["mesh"]].get("name") or f"node_{number}"
        del node["mesh"]
        for k, mesh in enumerate(own):
            node.setdefault("children", []).append(len(nodes))
            nodes.append({"name": f"{name}_{k}", "mesh": mesh})


def _place_instances(document: Document) -> None:
    """Give each instance of a mesh a node of its own."""
    nodes = document.json.get("nodes", [])
    for node in list(nodes):
        given = node.get("extensions", {}).get(_INSTANCES)
        if given is None or "mesh" not in node:
            continue
        rows = {name: document.array(index) for name, index in given["attributes"].items()}
        placed = {"TRANSLATION": "translation", "ROTATION": "rotation", "SCALE": "scale"}
        mesh = node.pop("mesh")
        for index in range(min(map(len, rows.values()), default=0)):
            values = {key: rows[name][index].tolist() for name, key in placed.items() if name in rows}
            node.setdefault("children", []).append(len(nodes))
            nodes.append({"mesh": mesh, **values})


def _world_matrices(nodes: list[dict[str, Any]]) -> list[np.ndarray]:
    """Return the column-vector matrix (4, 4) of each node in the world; nodes in a circle have their own alone."""
    parent = {child: index for index, node in enumerate(nodes) for child in node.get("children", [])}
    found = []
    for index in range(len(nodes)):
        matrix, at, seen = _matrix(nodes[index]), parent.get(index), {index}
        while at is not None and at not in seen:
            matrix = _matrix(nodes[at]) @ matrix
            seen.add(at)
            at = parent.get(at)
        found.append(matrix)
    return found


def _matrix(node: dict[str, Any]) -> np.ndarray:
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    matrix = np.eye(4)
    matrix[:3, :3] = matrix_from_quat(node.get("rotation", (0.0, 0.0, 0.0, 1.0))).T
    matrix[:3, :3] *= node.get("scale", (1.0, 1.0, 1.0))
    matrix[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return matrix
