"""Camera attributes given by name, held against what USD knows of cameras."""

from __future__ import annotations

from typing import Any

from pxr import Tf, Usd

from usdsdg.scenarios.config_problems import suggestion


def checked_camera_properties(properties: dict[str, Any]) -> dict[str, Any]:
    """The same properties, lists made tuples.

    Raises:
        ValueError: cameras have no attribute of a name, or a value does not fit it; names all of them.
    """
    stage = Usd.Stage.CreateInMemory()
    camera = stage.DefinePrim("/Camera", "Camera")
    plain = {name: tuple(value) if isinstance(value, list) else value for name, value in properties.items()}
    problems = [problem for name, value in plain.items() if (problem := _problem(camera, name, value))]
    if problems:
        raise ValueError("; ".join(problems))
    return plain


def _problem(camera: Usd.Prim, name: str, value: Any) -> str | None:
    attribute = camera.GetAttribute(name) if name.replace(":", "").isidentifier() else None
    if not attribute:
        known = [each.GetName() for each in camera.GetAttributes()]
        hint = suggestion(name, known) or f"; USD cameras have {', '.join(known)}"
        return f"{name} is no attribute of USD cameras{hint}"
    try:
        fits = attribute.Set(value)
    except (Tf.ErrorException, TypeError):
        fits = False
    return None if fits else f"{name}: {value!r} does not fit; expected a value of type {attribute.GetTypeName()}"
