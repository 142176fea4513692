"""`isaacsim.storage.native`: the assets root, files and folders, and what USD files refer to."""

from usdsdg.compat.isaacsim.storage.asset_paths import (
    is_absolute_path,
    is_local_path,
    is_mdl_file,
    is_path_external,
    is_valid_usd_file,
    path_dirname,
    path_join,
    path_relative,
)
from usdsdg.compat.isaacsim.storage.asset_search import (
    count_asset_references,
    find_absolute_paths_in_usds,
    find_external_references,
    find_files_recursive,
    find_filtered_files,
    find_filtered_files_async,
    get_stage_references,
    layer_has_missing_references,
    path_exists,
    prim_has_missing_references,
    prim_spec_has_missing_references,
    resolve_asset_path,
    resolve_asset_path_async,
)
from usdsdg.compat.omni.isaac import nucleus
from usdsdg.compat.omni.isaac.nucleus import *  # noqa: F403 - the same functions

__all__ = [
    "count_asset_references", "find_absolute_paths_in_usds", "find_external_references", "find_files_recursive",
    "find_filtered_files", "find_filtered_files_async", "get_stage_references", "is_absolute_path", "is_local_path",
    "is_mdl_file", "is_path_external", "is_valid_usd_file", "layer_has_missing_references", "path_dirname",
    "path_exists", "path_join", "path_relative", "prim_has_missing_references", "prim_spec_has_missing_references",
    "resolve_asset_path", "resolve_asset_path_async",
]  # fmt: skip
__all__ += nucleus.__all__
