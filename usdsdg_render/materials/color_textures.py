"""Textures with the displayColor of prototypes over which it varies."""

import hashlib
from dataclasses import replace

from usdsdg_render.geometry.color_atlas import color_atlas
from usdsdg_render.images.textures import TextureUse
from usdsdg_render.materials.display_color import NAME, DisplayColor
from usdsdg_render.materials.shading import Input, Material
from usdsdg_render.scene.scene import WRAP_CLAMP, Prototype, Texture


class ColorTextures:
    """One texture for each prototype with colors, made on first use."""

    def __init__(self) -> None:
        self._made: dict[int, tuple[Prototype, TextureUse, Texture]] = {}  # by id; holds the prototype, so ids are safe

    def apply(self, material: Material | DisplayColor, prototype: Prototype) -> Material:
        """Return the material with the prototype's colors, and with its opacities if it is the fallback material."""
        assert prototype.colors is not None
        _, use, _ = self._texture_of(prototype)
        has_opacity = material.name == NAME and (prototype.colors[..., 3] < 1.0).any()
        whole = material.material if isinstance(material, DisplayColor) else material
        colored = replace(whole, base_color=Input((1.0, 1.0, 1.0), texture=use), uv_primvar="")
        return replace(colored, opacity=Input((1.0,), texture=use, channel=3)) if has_opacity else colored

    def textures(self) -> list[tuple[TextureUse, Texture]]:
        """Return all textures made so far."""
        return [(use, texture) for _, use, texture in self._made.values()]

    def keep_only(self, prototypes: set[int]) -> None:
        """Drop the textures of all prototypes but these (by id)."""
        self._made = {key: made for key, made in self._made.items() if key in prototypes}

    def _texture_of(self, prototype: Prototype) -> tuple[Prototype, TextureUse, Texture]:
        if id(prototype) not in self._made:
            texels = color_atlas(prototype.colors)
            name = (
                f"{prototype.name}.primvars:displayColor#{hashlib.blake2b(texels.tobytes(), digest_size=8).hexdigest()}"
            )
            use = TextureUse(name, color_space="sRGB", wrap_s=WRAP_CLAMP, wrap_t=WRAP_CLAMP)
            self._made[id(prototype)] = (prototype, use, Texture(name, texels, True, WRAP_CLAMP, WRAP_CLAMP))
        return self._made[id(prototype)]
