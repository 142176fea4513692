"""glTF and GLB files made by code: what the format allows, its extensions, and broken files."""

import base64
import io
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from PIL import Image

from tests.soak.meshes.cases import makes
from tests.soak.meshes.shapes import checker, colored_cup, cup, exported, floats, textured_box, uvs_of

_COMPONENTS = {np.dtype(kind): code for kind, code in (("f4", 5126), ("u1", 5121), ("u2", 5123), ("u4", 5125))}
_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


class Model:
    """A glTF document with one buffer; `add` appends arrays to it."""

    def __init__(self) -> None:
        self.json: dict[str, Any] = {
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {}}]}], "accessors": [], "bufferViews": [], "buffers": [{}],
        }  # fmt: skip
        self.buffer = b""

    @property
    def primitive(self) -> dict[str, Any]:
        """The first primitive."""
        return self.json["meshes"][0]["primitives"][0]

    def view(self, content: bytes) -> int:
        """Append bytes and return their buffer view."""
        self.buffer += b"\0" * (-len(self.buffer) % 4)
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.buffer), "byteLength": len(content)})
        self.buffer += content
        return len(self.json["bufferViews"]) - 1

    def add(self, values: np.ndarray, **more: Any) -> int:
        """Append an array and return its accessor."""
        values = np.ascontiguousarray(values)
        size = 1 if values.ndim == 1 else int(np.prod(values.shape[1:]))
        entry = {"bufferView": self.view(values.tobytes()), "componentType": _COMPONENTS[values.dtype]}
        self.json["accessors"].append({**entry, "count": len(values), "type": _TYPES[size], **more})
        return len(self.json["accessors"]) - 1

    def image(self, content: bytes, kind: str) -> int:
        """Append a picture and return its texture."""
        self.json.setdefault("images", []).append({"bufferView": self.view(content), "mimeType": kind})
        self.json.setdefault("textures", []).append({"source": len(self.json["images"]) - 1})
        return len(self.json["textures"]) - 1

    def with_box(self) -> "Model":
        """Add the textured box."""
        box = textured_box()
        uv = uvs_of(box)
        self.primitive["attributes"] = {
            "POSITION": self.add(floats(box.vertices)),
            "NORMAL": self.add(floats(box.vertex_normals)),
            "TEXCOORD_0": self.add(floats(np.stack([uv[:, 0], 1 - uv[:, 1]], axis=1))),
        }
        self.primitive["indices"] = self.add(np.asarray(box.faces, np.uint16).ravel())
        return self

    def with_look(self, texture: dict[str, Any], **more: Any) -> "Model":
        """Add a material that shows a picture."""
        look = {"name": "checker", "pbrMetallicRoughness": {"baseColorTexture": texture, "metallicFactor": 0.0}, **more}
        self.json["materials"] = [look]
        self.primitive["material"] = 0
        return self

    def glb(self) -> bytes:
        """The bytes of a GLB file."""
        self.json["buffers"] = [{"byteLength": len(self.buffer)}]
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        body = self.buffer + b"\0" * (-len(self.buffer) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(body), b"BIN\0") + body
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks

    def gltf(self, uri: str | None = None) -> str:
        """The text of a glTF file; its buffer is a file, or inside."""
        inside = "data:application/octet-stream;base64," + base64.b64encode(self.buffer).decode()
        self.json["buffers"] = [{"byteLength": len(self.buffer), "uri": uri or inside}]
        return json.dumps(self.json)


def encoded(kind: str) -> bytes:
    """The checkered picture in a format of Pillow."""
    stream = io.BytesIO()
    checker().save(stream, kind)
    return stream.getvalue()


@makes("cup.glb")
def _(file: Path) -> None:
    cup().export(file)


@makes("textured.glb")
def _(file: Path) -> None:
    textured_box().export(file)


@makes("colors.glb")
def _(file: Path) -> None:
    colored_cup().export(file)


@makes("mirrored_node.glb")
def _(file: Path) -> None:
    model = Model().with_box()
    model.with_look({"index": model.image(encoded("PNG"), "image/png")})
    model.json["nodes"] = [{"mesh": 0, "scale": [-1, 1, 2], "translation": [0, 0.5, 0]}]
    file.write_bytes(model.glb())


@makes("jpeg.glb")
def _(file: Path) -> None:
    model = Model().with_box()
    file.write_bytes(model.with_look({"index": model.image(encoded("JPEG"), "image/jpeg")}).glb())


@makes("webp.glb")
def _(file: Path) -> None:
    model = Model().with_box()
    texture = model.image(encoded("WEBP"), "image/webp")
    model.json["textures"][texture] = {"extensions": {"EXT_texture_webp": {"source": 0}}}
    model.json["extensionsUsed"] = ["EXT_texture_webp"]
    file.write_bytes(model.with_look({"index": texture}).glb())


@makes("ktx2.glb", "KHR_texture_basisu")
def _(file: Path) -> None:
    model = Model().with_box()
    texture = model.image(b"\xabKTX 20\xbb\r\n\x1a\n" + b"\0" * 200, "image/ktx2")
    model.json["textures"][texture] = {"extensions": {"KHR_texture_basisu": {"source": 0}}}
    model.json["extensionsUsed"] = model.json["extensionsRequired"] = ["KHR_texture_basisu"]
    file.write_bytes(model.with_look({"index": texture}).glb())


@makes("draco.glb", "KHR_draco_mesh_compression", refused=True)
def _(file: Path) -> None:
    model = Model().with_box()
    view = model.view(b"DRACO" + bytes(range(100)))
    model.primitive["extensions"] = {"KHR_draco_mesh_compression": {"bufferView": view, "attributes": {"POSITION": 0}}}
    for accessor in model.json["accessors"]:
        del accessor["bufferView"]
    model.json["extensionsUsed"] = model.json["extensionsRequired"] = ["KHR_draco_mesh_compression"]
    file.write_bytes(model.glb())


@makes("meshopt.glb", "EXT_meshopt_compression", refused=True)
def _(file: Path) -> None:
    model = Model().with_box()
    for view in model.json["bufferViews"]:
        view["extensions"] = {
            "EXT_meshopt_compression": {
                "buffer": 0,
                "byteLength": 10,
                "byteStride": 12,
                "count": 1,
                "mode": "ATTRIBUTES",
            }
        }
    model.json["extensionsUsed"] = model.json["extensionsRequired"] = ["EXT_meshopt_compression"]
    file.write_bytes(model.glb())


@makes("quantized.glb", "")
def _(file: Path) -> None:
    model = Model().with_box()
    points = np.round((np.asarray(textured_box().vertices) + 0.1) / 0.2 * 65535).astype(np.uint16)
    model.primitive["attributes"]["POSITION"] = model.add(points, normalized=True)
    model.json["nodes"] = [{"mesh": 0, "scale": [0.2] * 3, "translation": [-0.1] * 3}]
    model.json["extensionsUsed"] = model.json["extensionsRequired"] = ["KHR_mesh_quantization"]
    file.write_bytes(model.glb())


@makes("second_uvs.glb")
def _(file: Path) -> None:
    model = Model().with_box()
    model.primitive["attributes"]["TEXCOORD_1"] = model.add(floats(uvs_of(textured_box())) * 4)
    file.write_bytes(model.with_look({"index": model.image(encoded("PNG"), "image/png"), "texCoord": 1}).glb())


@makes("moved_uvs.glb")
def _(file: Path) -> None:
    model = Model().with_box()
    transform = {"extensions": {"KHR_texture_transform": {"scale": [4, 4]}}}
    model.json["extensionsUsed"] = ["KHR_texture_transform"]
    file.write_bytes(model.with_look({"index": model.image(encoded("PNG"), "image/png"), **transform}).glb())


@makes("skinned.glb", "skeleton")
def _(file: Path) -> None:
    model = Model().with_box()
    count = len(textured_box().vertices)
    weights = np.tile(floats((1, 0, 0, 0)), (count, 1))
    model.primitive["attributes"] |= {
        "JOINTS_0": model.add(np.zeros((count, 4), np.uint8)), "WEIGHTS_0": model.add(weights),
    }  # fmt: skip
    model.json["nodes"] = [{"mesh": 0, "skin": 0, "children": [1]}, {"name": "bone"}]
    model.json["skins"] = [{"joints": [1], "inverseBindMatrices": model.add(np.eye(4, dtype=np.float32)[None])}]
    times, turns = model.add(floats((0, 1)), min=[0], max=[1]), model.add(floats([(0, 0, 0, 1), (0, 1, 0, 0)]))
    model.json["animations"] = [
        {
            "samplers": [{"input": times, "output": turns}],
            "channels": [{"sampler": 0, "target": {"node": 1, "path": "rotation"}}],
        }
    ]
    file.write_bytes(model.glb())


@makes("strip.gltf")
def _(file: Path) -> None:
    model = Model()
    points = floats([(i // 2 * 0.1, i % 2 * 0.2, 0.02 * i) for i in range(12)])
    model.primitive["attributes"]["POSITION"] = model.add(points)
    model.primitive["mode"] = 5
    file.write_text(model.gltf())


@makes("fan.gltf")
def _(file: Path) -> None:
    model = Model()
    angles = np.linspace(0, 5, 12)
    ring = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    model.primitive["attributes"]["POSITION"] = model.add(floats(np.concatenate([np.zeros((1, 3)), ring])))
    model.primitive["mode"] = 6
    file.write_text(model.gltf())


@makes("external.gltf")
def _(file: Path) -> None:
    model = Model().with_box()
    model.json["images"], model.json["textures"] = [{"uri": "K%C3%A4stchen%201.png"}], [{"source": 0}]
    checker().save(file.parent / "Kästchen 1.png")
    (file.parent / "data.bin").write_bytes(model.buffer)
    file.write_text(model.with_look({"index": 0}).gltf("data.bin"))


@makes("missing_picture.gltf", "gone.png is missing")
def _(file: Path) -> None:
    model = Model().with_box()
    model.json["images"], model.json["textures"] = [{"uri": "gone.png"}], [{"source": 0}]
    file.write_text(model.with_look({"index": 0}).gltf())


@makes("missing_buffer.gltf", "gone.bin", refused=True)
def _(file: Path) -> None:
    file.write_text(Model().with_box().gltf("gone.bin"))


@makes("sparse.gltf")
def _(file: Path) -> None:
    model = Model().with_box()
    moved = {"bufferView": model.view(floats([[0.3, 0.3, 0.3]]).tobytes())}
    at = {"bufferView": model.view(np.array([0], np.uint16).tobytes()), "componentType": 5123}
    model.json["accessors"][0]["sparse"] = {"count": 1, "indices": at, "values": moved}
    file.write_text(model.gltf())


@makes("points.glb", "no triangles", refused=True)
def _(file: Path) -> None:
    model = Model()
    model.primitive.update(attributes={"POSITION": model.add(floats(cup().vertices))}, mode=0)
    file.write_bytes(model.glb())


@makes("indices_outside.glb", "missing or infinite corners")
def _(file: Path) -> None:
    model = Model().with_box()
    indices = np.asarray(textured_box().faces, np.uint16).ravel()
    indices[4] = 60000
    model.primitive["indices"] = model.add(indices)
    file.write_bytes(model.glb())


@makes("circle_of_nodes.gltf", "", refused=None)
def _(file: Path) -> None:
    model = Model().with_box()
    model.json["nodes"] = [{"mesh": 0, "children": [1]}, {"children": [0]}]
    file.write_text(model.gltf())


@makes("cut.glb", "is cut off", refused=True)
def _(file: Path) -> None:
    content = exported(textured_box(), "glb")
    file.write_bytes(content[: len(content) // 2])


@makes("first_version.gltf", "only glTF 2", refused=True)
def _(file: Path) -> None:
    file.write_text(json.dumps({"asset": {"version": "1.0"}, "meshes": {}}))


@makes("really_a_picture.glb", "cannot be read as GLB", refused=True)
def _(file: Path) -> None:
    Image.new("RGB", (4, 4)).save(file, "PNG")


@makes("instances.glb")
def _(file: Path) -> None:
    model = Model().with_box()
    places = model.add(floats([(0, 0, 0), (0.3, 0, 0), (0.6, 0, 0)]))
    model.json["nodes"][0]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}}
    model.json["extensionsUsed"] = ["EXT_mesh_gpu_instancing"]
    file.write_bytes(model.glb())


@makes("morphed.glb")
def _(file: Path) -> None:
    model = Model().with_box()
    model.primitive["targets"] = [{"POSITION": model.add(floats(np.ones((36, 3)) * 0.1))}]
    model.json["meshes"][0]["weights"] = [0.0]
    file.write_bytes(model.glb())


@makes("two_meshes.glb")
def _(file: Path) -> None:
    scene = trimesh.Scene()
    scene.add_geometry(cup())
    scene.add_geometry(textured_box(), transform=trimesh.transformations.translation_matrix((0.25, 0, 0)))
    scene.export(file)
