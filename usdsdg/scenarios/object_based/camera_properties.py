"""Validate camera attributes given by name against the schema of USD cameras."""

from typing import Any

from pxr import Tf, Usd

from usdsdg.scenarios.config_errors import suggestion


def checked_camera_properties(properties: dict[str, Any]) -> dict[str, Any]:
    """Return the same properties, with lists as tuples.

    Raises:
        ValueError: a name is no attribute of cameras, or a value does not fit its type; one message names all of them.
    """
    stage = Usd.Stage.CreateInMemory()
    camera = stage.DefinePrim("/Camera", "Camera")
    converted = {name: tuple(value) if isinstance(value, list) else value for name, value in properties.items()}
    problems = [problem for name, value in converted.items() if (problem := _problem(camera, name, value))]
    if problems:
        raise ValueError("; ".join(problems))
    return converted


def _problem(camera: Usd.Prim, name: str, value: Any) -> str | None:
    attribute = camera.GetAttribute(name) if name.replace(":", "").isidentifier() else None
    if not attribute:
        known = [each.GetName() for each in camera.GetAttributes()]
        hint = suggestion(name, known) or f"; USD cameras have {', '.join(known)}"
        return f"{name} is not an attribute of USD cameras{hint}"
    try:
        fits = attribute.Set(value)
    except (Tf.ErrorException, TypeError):
        fits = False
    return None if fits else f"{name}: {value!r} does not fit; expected a value of type {attribute.GetTypeName()}"
