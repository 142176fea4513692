"""Assets: from a URL or path to a file below the assets root, with maps, mirrors and stand-ins for missing ones."""

from usdsdg.stage.assets.cache_folder import built_folder, cache_folder, replace_files
from usdsdg.stage.assets.dependencies import (
    MissingDependency,
    is_elsewhere,
    missing_dependencies,
    redirect,
    redirect_layer,
)
from usdsdg.stage.assets.file_checks import (
    check_file,
    check_neighbors,
    check_regular,
    not_a_file_of_its_own,
    why_no_layer,
)
from usdsdg.stage.assets.lookup import exists, locate, locate_or_none, paths_under_root
from usdsdg.stage.assets.maps import PathMap, get_maps, set_maps
from usdsdg.stage.assets.mesh_files import MESHES, PACKAGE, is_mesh, set_mesh_converter
from usdsdg.stage.assets.metrics import name_other_metrics, referenced_layers
from usdsdg.stage.assets.missing import (
    MissingAsset,
    MissingAssets,
    OnMissing,
    check_missing,
    get_on_missing,
    instead_of_folder,
    listed,
    missing_assets,
    note_missing,
    raise_missing,
    resolve,
    set_on_missing,
    where_looked,
)
from usdsdg.stage.assets.objects import open_layer, resolve_object, resolve_reference
from usdsdg.stage.assets.root import (
    HOW_TO_SET,
    ROOT_VARIABLE,
    Mirror,
    assets_root,
    configured_root,
    root_mirror,
    set_assets_root,
    set_fallback_root,
    set_mirror_factory,
)
from usdsdg.stage.assets.search_paths import add_search_path, remove_search_path
from usdsdg.stage.assets.stand_ins import set_units
from usdsdg.stage.assets.url import TOP_FOLDERS, is_remote, scheme_of, with_slashes

__all__ = [
    "HOW_TO_SET",
    "MESHES",
    "PACKAGE",
    "ROOT_VARIABLE",
    "TOP_FOLDERS",
    "Mirror",
    "MissingAsset",
    "MissingAssets",
    "MissingDependency",
    "OnMissing",
    "PathMap",
    "add_search_path",
    "assets_root",
    "built_folder",
    "cache_folder",
    "check_file",
    "check_missing",
    "check_neighbors",
    "check_regular",
    "configured_root",
    "exists",
    "get_maps",
    "get_on_missing",
    "instead_of_folder",
    "is_elsewhere",
    "is_mesh",
    "is_remote",
    "listed",
    "locate",
    "locate_or_none",
    "missing_assets",
    "missing_dependencies",
    "name_other_metrics",
    "not_a_file_of_its_own",
    "note_missing",
    "open_layer",
    "paths_under_root",
    "raise_missing",
    "redirect",
    "redirect_layer",
    "referenced_layers",
    "remove_search_path",
    "replace_files",
    "resolve",
    "resolve_object",
    "resolve_reference",
    "root_mirror",
    "scheme_of",
    "set_assets_root",
    "set_fallback_root",
    "set_maps",
    "set_mesh_converter",
    "set_mirror_factory",
    "set_on_missing",
    "set_units",
    "where_looked",
    "why_no_layer",
    "with_slashes",
]  # fmt: skip
