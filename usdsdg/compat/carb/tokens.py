"""`carb.tokens`: names in texts such as "${temp}/pictures", and what stands for them."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

from usdsdg.compat.isaacsim.core.utils.extensions import get_extension_path_from_name
from usdsdg.errors import Unsupported, warn_once
from usdsdg.stage.assets.cache_folder import cache_folder

RESOLVE_FLAG_NONE = 0
RESOLVE_FLAG_LEAVE_TOKEN_IF_NOT_FOUND = 1

_TOKEN = re.compile(r"\$\{([^{}]*)\}")
_PACKAGE = Path(__file__).parents[2]  # there is no folder of Kit; what a script looks for in it is missing there, too


class ITokens:
    """Tokens by name: folders of this application, packages on `sys.path`, and what scripts set."""

    def __init__(self) -> None:
        self._set: dict[str, str] = {}

    def resolve(self, string: str, flags: int = RESOLVE_FLAG_NONE) -> str:
        """Return the text with what its tokens stand for.

        A token that there is none of is left out, with a warning, or with RESOLVE_FLAG_LEAVE_TOKEN_IF_NOT_FOUND left
        as it is.
        """

        def value(match: re.Match[str]) -> str:
            found = self._value(match[1])
            if found is None and not flags & RESOLVE_FLAG_LEAVE_TOKEN_IF_NOT_FOUND:
                warn_once(f"carb.tokens: there is no token ${{{match[1]}}} in {string!r}; it is left out")
                return ""
            return match[0] if found is None else found

        return _TOKEN.sub(value, string)

    def set_value(self, name: str, value: str) -> None:
        self._set[name] = value

    def set_initial_value(self, name: str, value: str) -> None:
        """Set a token that has no value yet."""
        self._set.setdefault(name, value)

    def remove_token(self, name: str) -> bool:
        """Remove a token that was set; return whether there was one."""
        return self._set.pop(name, None) is not None

    def exists(self, name: str) -> bool:
        return self._value(name) is not None

    def _value(self, name: str) -> str | None:
        if name in self._set:
            return self._set[name]
        if name in ("kit", "app", "exe-path"):
            return _PACKAGE.as_posix()
        if name == "temp":
            return Path(tempfile.gettempdir()).as_posix()
        if name in ("cache", "data", "logs"):
            return (cache_folder() / name).as_posix()
        if name in ("omni_documents", "my_documents", "shared_documents", "app_documents"):
            return (Path.home() / "Documents").as_posix()
        try:
            return get_extension_path_from_name(name) if "." in name else None
        except Unsupported:
            return None


_tokens = ITokens()


def get_tokens_interface() -> ITokens:
    return _tokens


def acquire_tokens_interface() -> ITokens:
    return _tokens
