"""`omni.isaac.nucleus`: the assets root, and what is a file or a folder."""

from urllib.parse import urlsplit

from usdsdg.compat.omni import client
from usdsdg.errors import AssetError
from usdsdg.session.stage_context import assets_root

__all__ = [
    "build_server_list", "check_server", "check_server_async", "create_folder", "delete_folder", "find_nucleus_server",
    "get_assets_root_path", "get_assets_root_path_async", "get_assets_server", "get_full_asset_path",
    "get_full_asset_path_async", "get_isaac_asset_root_path", "get_nvidia_asset_root_path", "get_server_path",
    "get_server_path_async", "get_url_root", "is_dir", "is_dir_async", "is_file", "is_file_async", "list_folder",
    "recursive_list_folder", "verify_asset_root_path",
]  # fmt: skip


def get_assets_root_path(*, skip_check: bool = False) -> str:
    return assets_root()


async def get_assets_root_path_async(*, skip_check: bool = False) -> str:
    return assets_root()


def find_nucleus_server(suffix: str = "/Isaac") -> tuple[bool, str]:
    """Return True and the assets root, as scripts of Isaac Sim 2021 and 2022 look for it."""
    return True, assets_root()


def get_nvidia_asset_root_path() -> str:
    """Return the folder `/NVIDIA` of the assets root."""
    return f"{assets_root()}/NVIDIA"


def get_isaac_asset_root_path() -> str:
    """Return the folder `/Isaac` of the assets root."""
    return f"{assets_root()}/Isaac"


def get_server_path(suffix: str = "") -> str:
    """Return the assets root, which stands for every server.

    Raises:
        RuntimeError: there is nothing at `suffix` below it.
    """
    if not check_server(assets_root(), suffix):
        raise RuntimeError(f"the assets root {assets_root()} has no {suffix}; --assets-root names another")
    return assets_root()


async def get_server_path_async(suffix: str = "") -> str:
    """Run `get_server_path` in a coroutine."""
    return get_server_path(suffix)


def get_assets_server() -> str:
    return assets_root()


def build_server_list() -> list[str]:
    """Return the assets root alone: it stands for every server."""
    return [assets_root()]


def get_full_asset_path(path: str) -> str | None:
    """Return the path of an asset below the assets root, None where it is not there."""
    full = assets_root() + path
    return full if check_server("", full) else None


async def get_full_asset_path_async(path: str) -> str | None:
    """Run `get_full_asset_path` in a coroutine."""
    return get_full_asset_path(path)


def check_server(server: str, path: str, timeout: float = 10.0) -> bool:
    """Return whether a file or folder is there: on this machine, below the assets root, or mapped."""
    return client.stat(f"{server}{path}")[0] is client.Result.OK


async def check_server_async(server: str, path: str, timeout: float = 10.0) -> bool:
    """Run `check_server` in a coroutine."""
    return check_server(server, path)


def verify_asset_root_path(path: str) -> tuple[client.Result, str]:
    """Return whether a folder is there, and no version: folders of assets are not asked for theirs."""
    return client.stat(path)[0], ""


def get_url_root(url: str) -> str:
    """Return "scheme://host" of a URL.

    Raises:
        RuntimeError: it is none of omniverse, http or https.
    """
    split = urlsplit(url)
    if split.scheme not in ("omniverse", "http", "https"):
        raise RuntimeError(f"{url} is no URL of a server: it begins with none of omniverse://, http://, https://")
    return f"{split.scheme}://{split.netloc}"


def create_folder(server: str, path: str) -> bool:
    return client.create_folder(f"{server}{path}") is client.Result.OK


def delete_folder(server: str, path: str) -> bool:
    return client.delete(f"{server}{path}") is client.Result.OK


def list_folder(path: str) -> tuple[list[str], list[str]]:
    """Return the paths of the files in a folder, and those of its folders, each ending in "/"."""
    folder = path if path.endswith("/") else f"{path}/"
    files: list[str] = []
    folders: list[str] = []
    for entry in client.list(path)[1]:
        if entry.flags & client.ItemFlags.CAN_HAVE_CHILDREN:
            folders.append(f"{folder}{entry.relative_path}/")
        else:
            files.append(folder + entry.relative_path)
    return files, folders


def recursive_list_folder(path: str) -> list[str]:
    """Return the paths of all files below a folder."""
    files, folders = list_folder(path)
    return files + [file for each in folders for file in recursive_list_folder(each)]


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
