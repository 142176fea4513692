"""`omni.isaac.nucleus`: the assets root, and what is a file or a folder."""

from usdsdg.compat.omni import client
from usdsdg.errors import AssetError
from usdsdg.session.stage_context import assets_root

__all__ = [
    "find_nucleus_server", "get_assets_root_path", "get_assets_root_path_async", "is_dir", "is_dir_async", "is_file",
    "is_file_async",
]  # fmt: skip


def get_assets_root_path(*, skip_check: bool = False) -> str:
    return assets_root()


async def get_assets_root_path_async(*, skip_check: bool = False) -> str:
    return assets_root()


def find_nucleus_server(suffix: str = "/Isaac") -> tuple[bool, str]:
    """Return True and the assets root, as scripts of Isaac Sim 2021 and 2022 look for it."""
    return True, assets_root()


def is_file(path: str) -> bool:
    """Return whether a path or URL, also one below the assets root, is a file and not a folder.

    Raises:
        AssetError: there is neither.
    """
    return not _is_folder(path)


def is_dir(path: str) -> bool:
    """Return whether a path or URL, also one below the assets root, is a folder with entries.

    Raises:
        AssetError: there is neither a file nor a folder.
    """
    return _is_folder(path) and bool(client.list(path)[1])


async def is_file_async(path: str) -> bool:
    """Run `is_file` in a coroutine."""
    return is_file(path)


async def is_dir_async(path: str) -> bool:
    """Run `is_dir` in a coroutine."""
    return is_dir(path)


def _is_folder(path: str) -> bool:
    result, entry = client.stat(path)
    if entry is None:
        raise AssetError(f"{path} is neither a file nor a folder: {result.name}")
    return bool(entry.flags & client.ItemFlags.CAN_HAVE_CHILDREN)
