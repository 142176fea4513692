"""Randomizers: draws that need more than one attribute. Mirrors `rep.randomizer`."""

from collections.abc import Callable
from typing import Any

from usdsdg.randomizer.instances import instantiate
from usdsdg.randomizer.looks import color, materials, texture
from usdsdg.randomizer.scattering import scatter_2d, scatter_3d
from usdsdg.randomizer.turning import rotation
from usdsdg.user_functions import enter

__all__ = ["color", "instantiate", "materials", "register", "rotation", "scatter_2d", "scatter_3d", "texture"]


def register(fn: Callable[..., Any], override: bool = True, fn_name: str | None = None) -> None:
    """Make `rep.randomizer.<name>` call `fn`.

    Raises:
        ValueError: the name is no identifier, or taken while `override` is False.
    """
    enter(globals(), "randomizer", fn, override, fn_name)
