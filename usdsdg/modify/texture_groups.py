"""Groups of textures that belong together: what `utils.get_files_group` returns, or mappings by what each is for."""

import json
from collections.abc import Mapping
from typing import Any

from usdsdg.arguments.values import shown
from usdsdg.distribution import Distribution, one_of
from usdsdg.errors import ArgumentError

# What a texture can be for, and the inputs of OmniPBR that it sets.
TEXTURES = {
    "diffuse": "diffuse_texture",
    "normal": "normalmap_texture",
    "roughness": "reflectionroughness_texture",
    "metallic": "metallic_texture",
    "opacity": "opacity_texture",
}


def drawn_group(group: Any) -> Any:
    """Return an argument `texture_group` with a list of texts, as of `utils.get_files_group`, as a choice of these."""
    is_listed = isinstance(group, (list, tuple)) and len(group) > 0 and all(isinstance(each, str) for each in group)
    return one_of(list(group), None) if is_listed and not isinstance(group, Distribution) else group


def files_of(group: Any, suffixes: Mapping[str, str]) -> dict[str, str]:
    """Return the files of a texture group by what they are for.

    Args:
        group: {"diffuse": file, ...}, or a named group of files by suffix, {"Wood": {"_D": file, ...}}, as a mapping
            or as JSON.
        suffixes: which suffix marks which texture, {"diffuse": "_D"}; none for the first form.

    Raises:
        ArgumentError: it is something else, or has no file with such a suffix.
    """
    files = _unnamed(group)
    if not isinstance(files, dict) or not (suffixes or set(files) <= set(TEXTURES)):
        raise ArgumentError(
            f"texture_group is {shown(group)}; expected a mapping with the keys {', '.join(TEXTURES)}, or a group of "
            'utils.get_files_group and the suffixes of its textures, as in diffuse="_D"'
        )
    if missing := [suffix for suffix in suffixes.values() if suffix not in files]:
        raise ArgumentError(f"texture_group {shown(group)} has no {missing[0]!r}; it has {', '.join(files)}")
    return {role: files[suffix] for role, suffix in suffixes.items()} if suffixes else files


def _unnamed(group: Any) -> Any:
    if isinstance(group, str):
        try:
            group = json.loads(group)
        except ValueError:
            return None
    inner = list(group.values()) if isinstance(group, dict) else []
    return inner[0] if len(inner) == 1 and isinstance(inner[0], dict) else group
