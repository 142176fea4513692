"""Content for examples. Mirrors `rep.example`.

TEXTURES: files of images that tile, to choose from in `randomizer.texture`. Replicator's are photographs on its server,
ours are painted by code: cork, leather, cardboard, concrete, panel and cloth.

TEXTURES_DIR: a folder of images, some of those among them.

ASSETS: USD files of small objects, to choose from in `create.from_usd` and `randomizer.instantiate`; ours are parts of
machines. ASSETS_DIR is their folder, in which `variant.usd` is a sphere with the variants red, green and blue of
`colorVariant`.
"""

from pathlib import Path
from typing import Any

from usdsdg import demo

_PROPS = "Isaac/Environments/{}/Props/textures/{}.png"
_PICTURES = (
    ("Office", "SM_Board_cork"), ("Office", "SM_Briefcase_leather"),
    ("Simple_Warehouse", "SM_CardBoxA_01_414_cardboard"), ("Simple_Warehouse", "SM_Hall_01_concrete"),
    ("Simple_Warehouse", "SM_Hall_01_panel"),
    ("Hospital", "SM_MedicalBag_01a_cloth"),
)  # fmt: skip

__all__ = ["ASSETS", "ASSETS_DIR", "TEXTURES", "TEXTURES_DIR"]  # noqa: F822  # pyright: ignore[reportUnsupportedDunderAll]  # by __getattr__


def __getattr__(name: str) -> Any:
    if name == "TEXTURES_DIR":
        return f"{demo.root()}/{_PROPS.format('Simple_Warehouse', '')}".rpartition("/")[0]
    if name == "ASSETS_DIR":
        return demo.example_assets()
    if name == "ASSETS":
        return sorted(str(file) for file in Path(demo.example_assets()).glob("*.usd"))
    if name != "TEXTURES":
        hint = "; assets are below --assets-root, where isaacsim.storage.native.get_assets_root_path() says"
        raise AttributeError(
            f"module 'usdsdg.example' has no attribute {name!r}; it has {', '.join(__all__)}"
            + (hint if name.endswith("DIR") else "")
        )
    return [f"{demo.root()}/{_PROPS.format(place, picture)}" for place, picture in _PICTURES]
