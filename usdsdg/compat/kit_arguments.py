"""Arguments of Kit: `--/a/b=c` sets the setting /a/b, `--ext-folder FOLDER` adds a folder of extensions."""

from __future__ import annotations

import ast
from collections.abc import Sequence

from usdsdg.session.session import current
from usdsdg.session.settings.store import get_settings

SettingValue = bool | int | float | str | list["SettingValue"]

PREFIX = "--/"
EXTENSION_FOLDER = "--ext-folder"


def apply(arguments: Sequence[str]) -> None:
    """Set what arguments of Kit name; others, which are the script's own, are left alone."""
    rest = iter(arguments)
    for argument in rest:
        name, _, value = argument.partition("=")
        if argument.startswith(PREFIX):
            get_settings().set(name[2:], typed(value) if "=" in argument else True)
        elif name == EXTENSION_FOLDER:
            current().extension_manager.add_path(value or next(rest, ""))


def typed(text: str) -> SettingValue:
    """Return what Kit reads from a text: true, false, a number, [a, b, ...], or the text without its quotes."""
    text = text.strip()
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    if text[:1] == text[-1:] and text[:1] in ("'", '"') and len(text) > 1:
        return text[1:-1]
    if text.startswith("[") and text.endswith("]"):
        inner = text[1:-1].strip()
        return [typed(item) for item in inner.split(",")] if inner else []
    try:
        number = ast.literal_eval(text)
    except (SyntaxError, ValueError):
        return text
    return number if isinstance(number, (int, float)) else text
