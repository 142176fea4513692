"""What the materials of a glTF document say that trimesh does not hand on: exact factors, wrap modes, extensions."""

from __future__ import annotations

import base64
import binascii
import io
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

from PIL import Image

from usdsdg.image_files.unreadable import UNREADABLE
from usdsdg.meshes.readers.gltf_document import Document

_WRAPS = {10497: "repeat", 33071: "clamp", 33648: "mirror"}
_STRENGTH, _UNLIT = "KHR_materials_emissive_strength", "KHR_materials_unlit"
_GLOSS = "KHR_materials_pbrSpecularGlossiness"
_IOR, _COAT, _TRANSMISSION = "KHR_materials_ior", "KHR_materials_clearcoat", "KHR_materials_transmission"
PICTURES = {
    "color": "baseColorTexture",
    "packed": "metallicRoughnessTexture",
    "normal": "normalTexture",
    "occlusion": "occlusionTexture",
    "emission": "emissiveTexture",
}


@dataclass(frozen=True)
class Look:
    """One material, by its number in the document."""

    name: str
    color: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0)  # linear, with opacity
    specular: tuple[float, ...] | None = None  # linear; the packed picture is that of specular color and glossiness
    glossiness: float = 1.0
    emission: tuple[float, ...] = (0.0, 0.0, 0.0)
    is_unlit: bool = False
    normal_scale: float = 1.0
    ior: float = 1.5
    clearcoat: float = 0.0
    clearcoat_roughness: float = 0.0
    transmission: float = 0.0
    wraps: dict[str, tuple[str, str]] = field(default_factory=dict)  # of the pictures, by the keys of PICTURES


def take_over_glossiness(document: Document) -> None:
    """Put what a material of specular color and glossiness has in place of its metallic one, which is a stand-in."""
    for material in document.json.get("materials", []):
        gloss = material.get("extensions", {}).get(_GLOSS)
        if gloss is None:
            continue
        names = {
            "diffuseFactor": "baseColorFactor",
            "diffuseTexture": "baseColorTexture",
            "specularGlossinessTexture": "metallicRoughnessTexture",
        }
        surface = {core: gloss[name] for name, core in names.items() if name in gloss}
        material["pbrMetallicRoughness"] = {**surface, "metallicFactor": 0.0}


def read_looks(document: Document) -> tuple[list[Look], list[str]]:
    """Return all materials, and notes of what is left out of them; names become numbers, by which they are found."""
    notes, looks = [], []
    for number, material in enumerate(document.json.get("materials", [])):
        name = str(material.get("name") or "Material")
        surface, extensions = material.get("pbrMetallicRoughness", {}), material.get("extensions", {})
        strength = float(extensions.get(_STRENGTH, {}).get("emissiveStrength", 1.0))
        pictures = {role: surface.get(key, material.get(key)) for role, key in PICTURES.items()}
        gloss, coat = extensions.pop(_GLOSS, None), extensions.get(_COAT, {})
        looks.append(
            Look(
                name,
                color=tuple(map(float, surface.get("baseColorFactor", (1.0, 1.0, 1.0, 1.0)))),
                specular=None if gloss is None else tuple(map(float, gloss.get("specularFactor", (1.0, 1.0, 1.0)))),
                glossiness=float((gloss or {}).get("glossinessFactor", 1.0)),
                emission=tuple(float(each) * strength for each in material.get("emissiveFactor", (0.0, 0.0, 0.0))),
                is_unlit=_UNLIT in extensions,
                normal_scale=float(material.get("normalTexture", {}).get("scale", 1.0)),
                ior=float(extensions.get(_IOR, {}).get("ior", 1.5)),
                clearcoat=float(coat.get("clearcoatFactor", 0.0)),
                clearcoat_roughness=float(coat.get("clearcoatRoughnessFactor", 0.0)),
                transmission=_transmission(extensions),
                wraps={role: _wraps(document.json, each) for role, each in pictures.items() if isinstance(each, dict)},
            )
        )
        notes += _left_out(name, extensions)
        material["name"] = str(number)
    return looks, notes


def _wraps(model: dict[str, Any], picture: dict[str, Any]) -> tuple[str, str]:
    """Return the wrap modes of a picture along u and v."""
    textures, samplers = model.get("textures", []), model.get("samplers", [])
    texture = textures[picture["index"]] if picture.get("index") in range(len(textures)) else {}
    sampler = samplers[texture["sampler"]] if texture.get("sampler") in range(len(samplers)) else {}
    u, v = (_WRAPS.get(sampler.get(key, 10497), "repeat") for key in ("wrapS", "wrapT"))
    return u, v


def _left_out(name: str, extensions: dict[str, Any]) -> Iterator[str]:
    if _UNLIT in extensions:
        yield f"the material {name} is unlit; it is drawn as a lit one, without metal or highlights"
    read = [_STRENGTH, _UNLIT, _IOR, _COAT]
    if _transmission(extensions):
        read.append(_TRANSMISSION)
        yield f"what shines through the material {name} is drawn as through a clear pane, neither refracted nor tinted"
    if pictures := [each for each in extensions.get(_COAT, {}) if each.endswith("Texture")]:
        yield f"{', '.join(pictures)} of the material {name} {'is' if len(pictures) == 1 else 'are'} left out"
    if lost := [each for each in extensions if each not in read]:
        yield f"{', '.join(lost)} of the material {name} {'is' if len(lost) == 1 else 'are'} left out"


def _transmission(extensions: dict[str, Any]) -> float:
    """Return the fraction of light that goes through a material; 0 where a picture says where it does."""
    given = extensions.get(_TRANSMISSION, {})
    return 0.0 if "transmissionTexture" in given else float(given.get("transmissionFactor", 0.0))


def pictures_left_out(document: Document, beside: Callable[[str], bytes]) -> Iterator[str]:
    """Yield a note for each picture that cannot be read; `beside` reports those whose own file is missing."""
    for texture in document.json.get("textures", []):
        if "KHR_texture_basisu" in texture.get("extensions", {}) and "source" not in texture:
            yield "pictures of KHR_texture_basisu (KTX2) are not read, so their part of the look is left out"
    for number, image in enumerate(document.json.get("images", [])):
        if image.get("mimeType") == "image/ktx2":
            continue
        try:
            content = _content(document, image, beside)
            if content is not None:
                Image.open(io.BytesIO(content)).close()
        except UNREADABLE:
            where = "inside" if "bufferView" in image or str(image.get("uri")).startswith("data:") else "beside"
            name = image.get("name") or (image.get("uri", number) if where == "beside" else number)
            yield f"the picture {name} {where} the file cannot be read, so its part of the look is left out"


def _content(document: Document, image: dict[str, Any], beside: Callable[[str], bytes]) -> bytes | None:
    """Return the bytes of a picture; None where its file is missing."""
    if "bufferView" in image:
        return document.bytes_of_view(image["bufferView"])
    uri = str(image.get("uri", ""))
    if uri.startswith("data:"):
        try:
            return base64.b64decode(uri.partition(",")[2])
        except binascii.Error as error:
            raise ValueError(str(error)) from error
    try:
        return beside(uri)
    except FileNotFoundError:
        return None
