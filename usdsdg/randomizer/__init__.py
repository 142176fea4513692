"""Randomizers that write more than a single attribute: `rep.randomizer`."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from usdsdg.arguments.parameters import name_parameters
from usdsdg.arguments.registry import register_function
from usdsdg.randomizer import appearance_worlds as _appearance_worlds  # noqa: F401 - registers twins for worlds
from usdsdg.randomizer import scatter_worlds as _scatter_worlds  # noqa: F401
from usdsdg.randomizer import spheres as _spheres  # noqa: F401 - registers the actions of its nodes
from usdsdg.randomizer.appearance import color, materials, texture
from usdsdg.randomizer.instances import instantiate
from usdsdg.randomizer.rotations import rotation
from usdsdg.randomizer.scatter import scatter_2d, scatter_3d

__all__ = ["color", "instantiate", "materials", "register", "rotation", "scatter_2d", "scatter_3d", "texture"]


def register(fn: Callable[..., Any], override: bool = True, fn_name: str | None = None) -> None:
    """Make `rep.randomizer.<name>` call `fn`.

    Raises:
        ValueError: the name is not an identifier, or taken while `override` is False.
    """
    register_function(globals(), "randomizer", fn, override, fn_name)


if TYPE_CHECKING:

    def __getattr__(name: str) -> Any:
        """Return what a script has registered, of which a type checker cannot know."""


name_parameters(globals())
