"""Scopes and Xforms, which group other prims."""

from typing import Any

from pxr import Usd

from usdsdg.functional.new_prims import apply_common_arguments, define, new_paths


def scope(name: str | None = None, parent: Any = None, count: int = 1) -> list[Usd.Prim]:
    """Scopes, which group prims and have no transform."""
    return define(new_paths(name or "Scope", parent, count), "Scope", with_ops=False)


def xform(
    position: Any = None, scale: Any = None, rotation: Any = None, look_at: Any = None, look_at_up_axis: Any = None,
    relative_to: Any = None, pivot: Any = None, semantics: Any = None, visible: Any = True, name: str | None = None,
    parent: Any = None, count: int = 1,
) -> list[Usd.Prim]:  # fmt: skip
    """Empty transforms. `pivot` raises BadPrim, since an empty transform has no extent."""
    return apply_common_arguments(
        define(new_paths(name or "Xform", parent, count), "Xform"), position=position, scale=scale, rotation=rotation,
        look_at=look_at, look_at_up_axis=look_at_up_axis, pivot=pivot, relative_to=relative_to, semantics=semantics,
        visible=visible,
    )  # fmt: skip
