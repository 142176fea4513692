"""What a file may call: the public functions of `rep`, those that scripts have registered, and methods of results.

A file may come from a stranger, so its names are looked up in lists, never in the attributes of modules, which have
what the modules themselves import.
"""

import inspect
from collections.abc import Callable, Iterable
from typing import Any

import usdsdg
from usdsdg.arguments.registry import registered_functions

# Functions by family; after a dot, class methods. Functions that take a Python function, which no file can give, and
# those of `functional` that write or read files of any name are left out.
FUNCTIONS = {
    "create": "camera cone cube cylinder disk from_dir from_usd group light material_omnipbr mesh_decal plane "
    "projection_material render_product render_product_tiled sphere stereo_camera tiled_sensor torus xform",
    "get": "camera curve geomsubset graph light listener material mesh physics prim_at_path prims renderproduct "
    "rendervar scope shader shape skelanimation skeleton sound xform",
    "modify": "animation attribute material pose pose_camera_relative pose_orbit projection_material semantics time "
    "timeline variant visibility",
    "randomizer": "color instantiate materials rotation scatter_2d scatter_3d texture",
    "distribution": "choice combine log_uniform normal sequence uniform",
    "trigger": "on_custom_event on_frame on_time on_time_end",
    "physics": "collider drive_properties mass physics_material reset rigid_body simulate",
    "settings": "carb_settings get_physx_timestep set_physx_timestep set_render_pathtraced set_render_rtx_realtime "
    "set_stage_meters_per_unit set_stage_up_axis",
    "orchestrator": "preview run run_until_complete set_capture_on_play set_minimum_next_rt_subframes "
    "set_next_rt_subframes step stop wait_until_complete",
    "writers": "get get_writers WriterRegistry.get WriterRegistry.get_writers BasicWriter CocoWriter CosmosWriter "
    "FPSWriter KittiWriter PoseWriter",
    "WriterRegistry": "get get_writers",
    "writers_default": "BasicWriter CocoWriter CosmosWriter FPSWriter KittiWriter PoseWriter",
    "backends": "get BackendDispatch BackendGroup BackendRegistry.get_backend DiskBackend S3Backend",
    "annotators": "get get_augmentation augment augment_compose AnnotatorRegistry.get_annotator",
    "AnnotatorRegistry": "get_annotator",
    "utils": "compute_aabb create_node find_prims get_files_group get_graph get_node_targets get_non_xform_prims "
    "get_prim_variant_values get_prims_from_paths get_replicator_graph_exists get_usd_files read_prim_transform "
    "send_og_event set_target_prims",
}  # fmt: skip

# Submodules of `functional`; all public functions that they define may be called.
FUNCTIONAL = ("create", "create_batch", "get", "modify", "physics", "randomizer", "utils")

FAMILIES = (*FUNCTIONS, "functional")


def public_functions(family: str) -> list[str]:
    """Return the names below a family that a file may call: "cube" of create, "create.cube" of functional."""
    if family == "functional":
        return [f"{part}.{name}" for part in FUNCTIONAL for name in _own_functions(part)]
    registered = [name for name in registered_functions(family) if hasattr(getattr(usdsdg, family), name)]
    return [*FUNCTIONS.get(family, "").split(), *registered]


def public_function(name: str) -> Callable[..., Any] | None:
    """Return the function that a dotted name such as "create.cube" stands for; None where a file may not call it."""
    family, _, rest = name.partition(".")
    if rest not in public_functions(family):
        return None
    found: Any = getattr(usdsdg, family)
    for part in rest.split("."):
        found = getattr(found, part, None)
    return found if callable(found) else None


def public_method(holder: Any, parts: Iterable[str]) -> Callable[..., Any] | None:
    """Return the method that names lead to from the result of a group; None where a file may not call it.

    Only public attributes and methods of objects of usdsdg are looked at: a prim, for instance, leads to its stage,
    whose methods write files anywhere.
    """
    found = holder
    for part in parts:
        if part.startswith("_") or not _is_ours(found):
            return None
        found = getattr(found, part, None)
    return found if inspect.ismethod(found) and _is_ours(found.__self__) else None


def public_methods(holder: Any) -> list[str]:
    """Return the names of the methods of a group's result that a file may call."""
    if not _is_ours(holder):
        return []
    return [name for name in dir(type(holder)) if not name.startswith("_") and callable(getattr(type(holder), name))]


def _own_functions(part: str) -> list[str]:
    module = getattr(usdsdg.functional, part)
    listed = getattr(module, "__all__", None) or vars(module)
    return [
        name
        for name in listed
        if not name.startswith("_")
        and inspect.isfunction(found := getattr(module, name))
        and found.__module__.startswith("usdsdg.functional.")
    ]


def _is_ours(value: Any) -> bool:
    return any(each.__module__.partition(".")[0] == "usdsdg" for each in type(value).__mro__)
