"""`omni.kit.stage_templates`: new stages that hold what a template authors."""

from __future__ import annotations

import asyncio
import inspect
from collections.abc import Callable
from typing import Any

from pxr import Usd

from usdsdg.arguments.registry import near_misses
from usdsdg.errors import ArgumentError
from usdsdg.session import new_stages
from usdsdg.session.new_stages import NewStage
from usdsdg.session.session import current
from usdsdg.session.settings.store import get_settings
from usdsdg.session.stage_context import current_stage
from usdsdg.session.stage_context import new_stage as make_stage

Author = Callable[..., Any]

_DEFAULT_TEMPLATE = "/persistent/app/newStage/defaultTemplate"
_templates: dict[str, tuple[int, Author]] = {}


def _nothing(rootname: str, usd_context_name: str = "") -> None:
    """Author nothing beside what every new stage holds."""


def _with_light(rootname: str, usd_context_name: str = "") -> None:
    """Author the light of the application's new stages."""
    stage, kind = current_stage(), current().new_stage_kind
    if not stage.GetPrimAtPath(new_stages.DEFAULT_LIGHT):
        new_stages.add_light(stage, kind if kind is not NewStage.EMPTY else NewStage.ISAAC)


def register_template(name: str, new_stage_fn: Author, group: int = 0, rebuild: bool = True) -> bool:
    """Register what authors new stages of a name; return whether the name was free.

    Args:
        name: In any case.
        new_stage_fn: Called with the path of the default prim and, where it takes two arguments, the name of the
            context, while the new stage is the current one.
        group: Where it stands in `get_stage_template_list`.
        rebuild: Whether the menu would be made again.
    """
    if name.lower() in _templates:
        return False
    _templates[name.lower()] = (group, new_stage_fn)
    return True


def unregister_template(name: str, rebuild: bool = True) -> bool:
    """Forget a template; return whether it was there."""
    return _templates.pop(name.lower(), None) is not None


def get_stage_template_list() -> list[dict[str, tuple[str, Author]]]:
    """Return the templates by name, a dictionary for each group: the name and what authors the stage."""
    groups = sorted({group for group, _ in _templates.values()})
    return [{name: (name, fn) for name, (group, fn) in _templates.items() if group == each} for each in groups]


def get_stage_template(name: str) -> tuple[str, Author] | None:
    """Return the name of a template and what authors its stages; None for one that is not registered."""
    found = _templates.get(name.lower())
    return None if found is None else (name.lower(), found[1])


def get_default_template() -> str:
    """Return the name of the template that a setting names; where it names none, "empty"."""
    return str(get_settings().get(_DEFAULT_TEMPLATE) or "empty")


def new_stage(
    on_new_stage_fn: Callable[[bool, str], Any] | None = None,
    template: str | None = "empty",
    usd_context: object = None,
) -> bool:
    """Make a new stage the current one; with `template` None, of the default template.

    Args:
        on_new_stage_fn: Called with True and "" when the stage is there.
        template: The name of a template, in any case.
        usd_context: There is one.

    Raises:
        ArgumentError: no template has this name.
    """
    author = _author_of(get_default_template() if template is None else template)
    stage = make_stage()
    arguments = (str(stage.GetDefaultPrim().GetPath()) if stage.GetDefaultPrim() else "/World", "")
    author(*arguments[: _number_taken(author)])
    if on_new_stage_fn is not None:
        on_new_stage_fn(True, "")
    return True


def new_stage_with_callback(
    on_new_stage_fn: Callable[[bool, str], Any] | None = None,
    template: str | None = "empty",
    usd_context: object = None,
) -> bool:
    """Do as `new_stage` does."""
    return new_stage(on_new_stage_fn, template, usd_context)


async def new_stage_async(template: str | None = "empty", usd_context: object = None) -> tuple[bool, str]:
    """Run `new_stage` in a coroutine; return True and ""."""
    new_stage(None, template, usd_context)
    await asyncio.sleep(0)
    return True, ""


def stage_path_exists(path: str) -> bool:
    """Return whether the current stage has a prim at a path."""
    stage: Usd.Stage = current_stage()
    return bool(stage.GetPrimAtPath(path))


def _author_of(name: str) -> Author:
    found = get_stage_template(name)
    if found is None:
        close = near_misses(name, _templates)
        names = ", ".join(sorted(_templates))
        hint = f"did you mean {' or '.join(close)}?" if close else f"there are {names}"
        raise ArgumentError(f"no template of new stages is named {name!r}; {hint}")
    return found[1]


def _number_taken(author: Author) -> int:
    try:
        parameters = inspect.signature(author).parameters.values()
    except ValueError:  # of a function in C
        return 1
    if any(each.kind is each.VAR_POSITIONAL for each in parameters):
        return 2
    return min(2, sum(each.kind in (each.POSITIONAL_ONLY, each.POSITIONAL_OR_KEYWORD) for each in parameters))


register_template("empty", _nothing)
register_template("default stage", _with_light)
register_template("sunlight", _with_light, 1)
