"""`isaacsim.core.utils.nucleus`: the assets root, and what is a file or a folder."""

from usdsdg.compat.omni.isaac.nucleus import (
    find_nucleus_server,
    get_assets_root_path,
    get_assets_root_path_async,
    is_dir,
    is_dir_async,
    is_file,
    is_file_async,
)

__all__ = [
    "find_nucleus_server", "get_assets_root_path", "get_assets_root_path_async", "is_dir", "is_dir_async", "is_file",
    "is_file_async",
]  # fmt: skip
