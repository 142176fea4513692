"""`omni.ext`: extensions, which are all there from the start."""

from __future__ import annotations

import importlib
import importlib.util
import os
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

from usdsdg.errors import Unsupported

__all__ = ["ExtensionManager", "IExt"]

# The version of every extension.
VERSION = "0.0.0"


class IExt:
    """The base of a script's own extension; nothing calls its methods."""

    def on_startup(self, ext_id: str) -> None:
        """Do nothing."""

    def on_shutdown(self) -> None:
        """Do nothing."""


class ExtensionManager:
    """Answers what scripts ask about extensions.

    What usdsdg has of an extension is always importable, so enabling one only notes its name; an import of what it does
    not have says so. Folders of extensions are those that a script or Kit's argument --ext-folder adds.
    """

    def __init__(self) -> None:
        self._chosen: dict[str, bool] = {}
        self._folders: list[str] = []

    def is_extension_enabled(self, name: str) -> bool:
        """Return whether an extension is enabled: by default, those whose modules usdsdg has."""
        name = _name(name)
        return self._chosen.get(name, _is_module(name))

    def set_extension_enabled(self, extension_id: str, enabled: bool) -> bool:
        """Note whether an extension is enabled."""
        self._chosen[_name(extension_id)] = bool(enabled)
        return True

    set_extension_enabled_immediate = set_extension_enabled

    def get_enabled_extension_id(self, name: str) -> str:
        """Return the id of an enabled extension, "" of others."""
        return f"{_name(name)}-{VERSION}" if self.is_extension_enabled(name) else ""

    def get_extension_id_by_module(self, module: str | ModuleType) -> str:
        """Return the id of the extension that a module belongs to."""
        return f"{module if isinstance(module, str) else module.__name__}-{VERSION}"

    def get_extensions(self) -> tuple[dict[str, Any], ...]:
        """Return "id", "name" and "enabled" of each extension that was enabled or disabled."""
        return tuple({"id": f"{k}-{VERSION}", "name": k, "enabled": v} for k, v in sorted(self._chosen.items()))

    def add_path(self, path: str, type: Any = None) -> None:
        """Add a folder of extensions."""
        if path not in self._folders:
            self._folders.append(str(path))

    def remove_path(self, path: str) -> None:
        """Remove a folder of extensions."""
        if path in self._folders:
            self._folders.remove(path)

    def get_folders(self) -> list[dict[str, Any]]:
        """Return the folders of extensions, each as {"path": ...}."""
        return [{"path": folder} for folder in self._folders]

    def get_extension_path(self, extension_id: str) -> str:
        """Return the folder of an extension, with its data files.

        Where no folder of extensions has it, this is the folder in which its modules lie under their full names, as
        below an extension's folder; there are no data files.

        Raises:
            Unsupported: neither a folder of extensions nor usdsdg has it.
        """
        name = _name(extension_id)
        for folder in self._folders:
            for found in (Path(folder) / name, Path(folder) / extension_id):
                if found.is_dir():
                    return str(found)
        if _is_module(name):
            return str(Path(__file__).resolve().parents[1])
        raise Unsupported(
            f"get_extension_path({extension_id!r}): usdsdg is not made of extensions and has none of their files; "
            "give the folder that holds the extension's own folder with --ext-folder FOLDER, as to Isaac Sim"
        )

    def get_extension_path_by_module(self, module: str | ModuleType) -> str:
        """Return the folder of the extension that a module belongs to.

        Raises:
            Unsupported: none of the folders of extensions has it.
        """
        return self.get_extension_path(module if isinstance(module, str) else module.__name__)


def _name(extension_id: str) -> str:
    """Return the name in an id such as "omni.usd-1.2.3"."""
    name, _, version = extension_id.partition("-")
    return name if version[:1].isdigit() else extension_id


def _is_module(name: str) -> bool:
    if name in sys.modules:
        return True
    try:
        return importlib.util.find_spec(name) is not None
    except (ModuleNotFoundError, ValueError):
        return False


def folder_of_extensions(path: str) -> str:
    """Return the absolute path of a folder of extensions; one extension's own folder gives its parent."""
    folder = os.path.abspath(path)
    return os.path.dirname(folder) if os.path.isdir(os.path.join(folder, "config")) else folder
