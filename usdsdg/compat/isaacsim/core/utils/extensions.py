"""`isaacsim.core.utils.extensions`: there are no extensions, so enabling and disabling do nothing.

A script's own extension is a package on `sys.path`, such as `omni.mine`, and its path the folder that holds it.
"""

import sys
from pathlib import Path

from usdsdg.errors import Unsupported


def enable_extension(extension_name: str) -> bool:
    return True


def disable_extension(extension_name: str) -> bool:
    return True


def get_extension_path_from_name(extension_name: str) -> str:
    """Return the folder that holds the package of a script's own extension.

    Raises:
        Unsupported: there is no such package; Omniverse's extensions and their files are not here.
    """
    parts = extension_name.split(".")
    for entry in sys.path:
        if any(Path(entry, *parts).rglob("*.py")):
            return str(Path(entry).resolve())
    raise Unsupported(
        f"get_extension_path_from_name: no folder of sys.path holds a package {extension_name!r}; extensions of "
        "Omniverse are not here, so copy the files that the script needs from it, and give their path"
    )


def get_extension_path(ext_id: str) -> str:
    """As `get_extension_path_from_name`, of a name with a version: "omni.mine-1.0.0"."""
    return get_extension_path_from_name(ext_id.partition("-")[0])


def get_extension_id(extension_name: str) -> str:
    """Return the name, as versions are not known."""
    return extension_name
