"""Parse MDL files that only call a template of Omniverse with arguments, as its material libraries do:

    export material Oak(*) = OmniPBR(diffuse_texture: texture_2d("./oak.png", ::tex::gamma_srgb), bump_factor: 0.5f);

Only constant and texture arguments are read; MDL is not evaluated.
"""

import os
import re
from typing import NamedTuple

from pxr import Gf, Sdf, Usd

from usdsdg_render.images import image_files

_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.S)
_ANNOTATION = re.compile(r"\[\[.*?\]\]", re.S)
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?[fFdD]?$")
_CALL = re.compile(r"(?:::)?(?:\w+::)*(\w+)\s*\((.*)\)$", re.S)
_KINDS = {1: Sdf.ValueTypeNames.Float, 2: Sdf.ValueTypeNames.Float2, 3: Sdf.ValueTypeNames.Color3f}


class Texture2d(NamedTuple):
    """A texture_2d argument."""

    file: str  # as written
    color_space: str  # sRGB, raw or auto


class Preset(NamedTuple):
    """A template, and a prim whose inputs are the arguments (on a stage of its own, kept alive here)."""

    template: str
    prim: Usd.Prim
    stage: Usd.Stage


def read_preset(file: str, name: str, path: Sdf.Path) -> Preset | None:
    """Read the template and the arguments of the material `name`; None where it is not such a call.

    Raises:
        AssetUnreadable: the file cannot be opened.
    """
    found = parse(image_files.read_bytes(file).decode("utf-8", "replace"), name)
    if found is None:
        return None
    template, values = found
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim(path, "Shader")
    for key, value in values.items():
        _author(prim, f"inputs:{key}", value, os.path.dirname(file))
    return Preset(template, prim, stage)


def _author(prim: Usd.Prim, name: str, value: bool | tuple[float, ...] | Texture2d, folder: str) -> None:
    if isinstance(value, Texture2d):
        attribute = prim.CreateAttribute(name, Sdf.ValueTypeNames.Asset)
        attribute.Set(value.file if os.path.isabs(value.file) else os.path.normpath(os.path.join(folder, value.file)))
        attribute.SetColorSpace(value.color_space)
    elif isinstance(value, bool):
        prim.CreateAttribute(name, Sdf.ValueTypeNames.Bool).Set(value)
    elif len(value) in _KINDS:
        convert = {1: lambda v: v[0], 2: lambda v: Gf.Vec2f(*v), 3: lambda v: Gf.Vec3f(*v)}[len(value)]
        prim.CreateAttribute(name, _KINDS[len(value)]).Set(convert(value))


def parse(text: str, name: str) -> tuple[str, dict[str, bool | tuple[float, ...] | Texture2d]] | None:
    """Return (template, its constant arguments) of a material in the text of a module; None if it is no such call."""
    text = _ANNOTATION.sub("", _COMMENT.sub("", text))
    start = re.search(rf"export\s+material\s+{re.escape(name)}\s*\(", text)
    if start is None:
        return None
    parameters_end = _closing(text, start.end())
    template = re.match(r"\s*=\s*(?:::)?(?:\w+::)*(\w+)\s*\(", text[parameters_end + 1 :])
    if template is None:
        return None
    begin = parameters_end + 1 + template.end()
    values = {}
    for argument in _split(text[begin : _closing(text, begin)]):
        key, colon, expression = argument.partition(":")
        value = _value(expression.strip())
        if colon and not expression.startswith(":") and value is not None:
            values[key.strip()] = value
    return template[1], values


def _closing(text: str, begin: int) -> int:
    """Index of the parenthesis that closes the one opened before `begin`; strings are skipped."""
    depth = 1
    for match in re.compile(r'"[^"]*"|[()]').finditer(text, begin):
        depth += {"(": 1, ")": -1}.get(match[0], 0)
        if depth == 0:
            return match.start()
    return len(text)


def _split(arguments: str) -> list[str]:
    """Split arguments at commas outside of parentheses and strings."""
    parts, depth = [""], 0
    for token in re.findall(r'"[^"]*"|[(),]|[^"(),]+', arguments):
        depth += {"(": 1, ")": -1}.get(token, 0)
        if token == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += token
    return parts


def _value(expression: str) -> bool | tuple[float, ...] | Texture2d | None:
    """Value of a constant expression; None for any other."""
    if expression in ("true", "false"):
        return expression == "true"
    if _NUMBER.match(expression):
        return (float(expression.rstrip("fFdD")),)
    call = _CALL.match(expression)
    if call is None:
        return None
    kind, arguments = call[1], [part.strip() for part in _split(call[2])]
    if kind == "texture_2d":
        file = arguments[0].strip('"')
        space = "sRGB" if "gamma_srgb" in call[2] else "raw" if "gamma_linear" in call[2] else "auto"
        return Texture2d(file, space) if file else None
    width = {"color": 3, "float2": 2, "float3": 3}.get(kind, 0)
    if width == 0 or not all(map(_NUMBER.match, arguments)):
        return None
    numbers = tuple(float(part.rstrip("fFdD")) for part in arguments)
    return numbers * width if len(numbers) == 1 else numbers
