"""What trimesh does not read of OBJ and its materials: several libraries, opacity, glow, options."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
from PIL import Image

from usdsdg.meshes.model import Material, Texture, roughness_of_exponent
from usdsdg.meshes.readers.obj_lines import plain_lines

# The name of the one library that trimesh gets.
LIBRARY = "usdsdg.mtl"
_LIBRARY_LINE = re.compile(rb"^[ \t]*mtllib[ \t]+(.*?)[ \t]*\r?$", re.MULTILINE)
_USED = re.compile(rb"^[ \t]*usemtl[ \t]+(.*?)[ \t]*\r?$", re.MULTILINE)
_DEFINED = re.compile(rb"^[ \t]*newmtl[ \t]+(.*?)[ \t]*\r?$", re.MULTILINE)
# How many values the options of a picture take; of -o, -s and -t from one to three.
_OPTIONS = {
    "-blendu": 1, "-blendv": 1, "-cc": 1, "-clamp": 1, "-imfchan": 1, "-texres": 1, "-bm": 1, "-type": 1, "-boost": 1,
    "-colorspace": 1, "-mm": 2, "-o": 3, "-s": 3, "-t": 3,
}  # fmt: skip
_SHIFTS = ("-o", "-s", "-t", "-clamp", "-mm")
# Parts of a material that are not read, in the words of MTL.
_LEFT_OUT = ("map_bump", "bump", "disp", "map_ks", "map_ns", "map_pr", "map_pm", "map_ps", "refl", "decal")
_PICTURES = {"map_kd": "diffuse", "map_ke": "emission", "map_d": "opacity", "norm": "normal", "map_kn": "normal"}


def prepared(content: bytes, find: Callable[[str], bytes | None]) -> tuple[bytes, bytes, list[str], list[str]]:
    """Return a file in lines that trimesh reads, its libraries as one, notes, and the libraries it lacks.

    find: gives the bytes of a file beside it by its name; None if there is none.
    """
    content = content.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ")
    libraries, notes, missing = [], [], []
    for line in dict.fromkeys(_LIBRARY_LINE.findall(content)):
        found, lost = _libraries(line.decode("utf-8", "replace"), find)
        libraries += found
        missing += lost
    library, lost_options = _without_options(b"\n".join(libraries))
    notes += lost_options
    if libraries:
        unknown = dict.fromkeys(each for each in _USED.findall(content) if each not in _DEFINED.findall(library))
        for name in unknown:
            notes.append(f"{name.decode('utf-8', 'replace')} is in none of its material files, so it has no look")
    content = _LIBRARY_LINE.sub(b"", content)
    if libraries:
        content = b"mtllib " + LIBRARY.encode() + b"\n" + content
    content, lost_faces = plain_lines(content)
    return content, library, [*notes, *lost_faces], missing


def _libraries(line: str, find: Callable[[str], bytes | None]) -> tuple[list[bytes], list[str]]:
    """Return the material files of a line and the names of those that are missing: one with spaces, or several."""
    whole = find(line)
    if whole is not None:
        return [whole], []
    found = {name: find(name) for name in (line.split() if line.lower().count(".mtl") > 1 else ())}
    if not found:
        return [], [line]
    return [each for each in found.values() if each is not None], [name for name, each in found.items() if each is None]


def _without_options(library: bytes) -> tuple[bytes, list[str]]:
    """Return a library whose pictures have no options, of which trimesh would make a part of their names; and notes."""
    lines, notes = library.split(b"\n"), []
    for number, line in enumerate(lines):
        words = line.decode("utf-8", "replace").split()
        if len(words) < 3 or words[0].lower() not in _PICTURES or not words[1].startswith("-"):
            continue
        options, name = split_options(words[1:])
        lines[number] = f"{words[0]} {name}".encode()
        lost = [each for each in options if each.split()[0] in _SHIFTS and not _changes_nothing(each)]
        if lost:
            notes.append(f"the options {' '.join(lost)} of the picture {name} are left out")
    return b"\n".join(lines), notes


def split_options(words: list[str]) -> tuple[list[str], str]:
    """Split what follows the key of a picture in MTL into options with their values, and the name of the file."""
    options, at = [], 0
    while at < len(words) - 1 and words[at].lower() in _OPTIONS:
        most, end = _OPTIONS[words[at].lower()], at + 1
        while end < min(at + 1 + most, len(words) - 1) and (most < 3 or _is_number(words[end])):
            end += 1
        options.append(" ".join(words[at:end]))
        at = end
    return options, " ".join(words[at:])


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _changes_nothing(option: str) -> bool:
    key, *values = option.split()
    return all(value == "off" or (_is_number(value) and float(value) == (key == "-s")) for value in values)


def material_of(
    name: str, given: Any, texture: Texture | None, opened: Callable[[str], Image.Image | None], notes: list[str]
) -> Material:
    """Convert a material of MTL.

    texture: its map_Kd. opened: opens the picture of a name; None where there is none.
    """
    own = dict(given.kwargs)
    pictures = {role: opened(split_options(own[key])[1]) for key, role in _PICTURES.items() if key in own}
    if lost := [key for key in own if key in _LEFT_OUT]:
        notes.append(f"{', '.join(lost)} of the material {name} {'is' if len(lost) == 1 else 'are'} left out")
    red, green, blue, alpha = (np.asarray(given.diffuse)[:4] / 255.0).tolist()
    opacity = _opacity(own, name, notes) if {"d", "tr"} & own.keys() else alpha
    mask = pictures.get("opacity")
    color = texture
    if mask is not None:
        color = Texture(with_mask(texture and texture.image, mask), f"{name}_color", is_color=True)
    glow, normal = pictures.get("emission"), pictures.get("normal")
    emission = _color(own.get("ke"), (0.0, 0.0, 0.0))
    if glow is not None and not any(emission):
        emission = (1.0, 1.0, 1.0)
    exponent = float(given.glossiness or 0.0)
    return Material(
        name,
        # A simple material's color is the texture's where there is one.
        color=(1.0, 1.0, 1.0) if texture is not None else _color(own.get("kd"), (red, green, blue)),
        color_texture=color,
        opacity=opacity,
        opacity_from_color=color is not None and has_alpha(color.image),
        metallic=float(np.clip(_number(own.get("pm"), 0.0), 0.0, 1.0)),
        roughness=float(np.clip(_number(own.get("pr"), roughness_of_exponent(exponent)), 0.0, 1.0)),
        emission=emission,
        emission_texture=None if glow is None else Texture(glow, f"{name}_emission", is_color=True),
        normal_texture=None if normal is None else Texture(normal, f"{name}_normal"),
    )


def has_alpha(image: Image.Image) -> bool:
    """Return whether some of a picture is not opaque."""
    alpha = _alpha(image)
    return alpha is not None and bool(np.asarray(alpha).min() < 255)


def _alpha(image: Image.Image) -> Image.Image | None:
    """Return the alpha of a picture, which may be that of entries of its palette or of one of its colors."""
    if image.mode in ("RGBA", "LA", "PA"):
        return image.getchannel("A")
    if "transparency" in image.info and image.mode in ("P", "RGB", "L"):
        return image.convert("RGBA").getchannel("A")
    return None


def with_mask(picture: Image.Image | None, mask: Image.Image) -> Image.Image:
    """Return the picture of a color, or a white one, with a mask as its alpha: the mask's own alpha, or its gray."""
    color = Image.new("RGB", mask.size, "white")
    if picture is not None:
        color = picture.convert("RGBA").convert("RGB")  # of a palette with transparency Pillow warns otherwise
    own = _alpha(mask)
    alpha = own if own is not None and has_alpha(mask) else mask.convert("L")
    color = color.copy()
    color.putalpha(alpha.resize(color.size) if alpha.size != color.size else alpha)
    return color


def _opacity(own: dict[str, Any], name: str, notes: list[str]) -> float:
    """Return `d`, else one minus `Tr`, of which some programs write 1 for what is opaque."""
    if "d" in own:
        words = own["d"]
        return float(np.clip(_number(words[1:] if words[:1] == ["-halo"] else words, 1.0), 0.0, 1.0))
    transparency = float(np.clip(_number(own.get("tr"), 0.0), 0.0, 1.0))
    if transparency == 1.0:
        notes.append(f"Tr of the material {name} is 1, which would be invisible, so it is drawn opaque")
        return 1.0
    return 1.0 - transparency


def _number(words: Any, default: float) -> float:
    first: Any = words[0] if isinstance(words, (list, tuple)) and words else words
    try:
        return float(first)
    except (TypeError, ValueError):
        return default


def _color(words: Any, default: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return a color of one or three numbers."""
    given: Any = words if isinstance(words, (list, tuple)) else [words]
    try:
        values = [float(each) for each in given]
    except (TypeError, ValueError):
        return default
    values = values * 3 if len(values) == 1 else values
    return (values[0], values[1], values[2]) if len(values) >= 3 else default
