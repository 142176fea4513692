"""Scopes and Xforms, which group other prims."""

from typing import Any

from pxr import Usd

from usdsdg.functional.new_prims import apply_common_arguments, define, new_paths


def scope(count: int = 1, name: str | None = None, parent: Any = None) -> list[Usd.Prim]:
    """Scopes, which group prims and have no transform."""
    return define(new_paths(name or "Scope", parent, count), "Scope", with_ops=False)


def xform(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    pivot: Any = None, relative_to: Any = None, semantics: Any = None, visible: Any = True, count: int = 1,
    name: str | None = None, parent: Any = None, material: Any = None,
) -> list[Usd.Prim]:  # fmt: skip
    """Empty transforms; a `material` is that of all prims that come below.

    Raises:
        BadPrim: `pivot` is given: an empty transform has no extent.
    """
    return apply_common_arguments(
        define(new_paths(name or "Xform", parent, count), "Xform"), position=position, scale=scale, rotation=rotation,
        look_at=look_at, look_at_up_axis=look_at_up_axis, pivot=pivot, relative_to=relative_to, semantics=semantics,
        visible=visible, material=material,
    )  # fmt: skip
