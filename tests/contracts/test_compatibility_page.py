"""docs/compatibility.md lists what there is: its tables agree with the registries and modules."""

import re
from pathlib import Path

import pytest

import usdsdg as rep
from usdsdg import settings
from usdsdg.annotators import catalogue
from usdsdg.writers import backends
from usdsdg.writers import catalogue as writers

PAGE = (Path(__file__).parents[2] / "docs" / "compatibility.md").read_text(encoding="utf-8")

# What Replicator 1.12 calls its functions, by family; those that exist here must be on the page.
REPLICATOR = {
    "create": "sphere torus disk plane cube cylinder cone xform camera stereo_camera light render_product "
    "render_product_tiled from_usd from_dir group material_omnipbr mdl_from_json projection_material mesh_decal "
    "register",
    "modify": "semantics pose pose_camera_relative pose_orbit attribute visibility variant material animation "
    "projection_material timeline time frame register",
    "randomizer": "scatter_2d scatter_3d materials instantiate rotation texture color register",
    "distribution": "uniform normal log_uniform choice sequence combine register",
    "trigger": "on_frame on_time on_time_end on_key_press on_custom_event on_condition register",
    "physics": "rigid_body collider mass drive_properties physics_material simulate reset",
    "settings": "carb_settings get_physx_timestep set_physx_timestep set_render_rtx_realtime set_render_pathtraced "
    "set_stage_meters_per_unit set_stage_up_axis",
    "utils": "compute_aabb create_node find_prims get_files_group get_graph get_node_targets get_non_xform_prims "
    "get_prim_variant_values get_prims_from_paths get_replicator_graph_exists get_usd_files read_prim_transform "
    "send_og_event sequential set_target_prims ReplicatorItem ReplicatorWrapper auto_connect",
}  # fmt: skip
# There only to say why it is not.
REFUSED = {"on_key_press"}


def words(text: str) -> set[str]:
    """Everything in backticks, split at spaces."""
    return {word for part in re.findall(r"`([^`]*)`", text) for word in part.split()}


def section(title: str) -> str:
    return re.split(r"\n#+ ", PAGE.split(f"# {title}\n", 1)[1], maxsplit=1)[0]


def row(name: str) -> set[str]:
    (line,) = re.findall(rf"^\| `?{name}`? \|(.*)\|$", section("Replicator"), re.MULTILINE)
    return words(line)


@pytest.mark.parametrize("family", REPLICATOR)
def test_families(family):
    module = getattr(rep, family)
    there = {name for name in REPLICATOR[family].split() if hasattr(module, name)} - REFUSED
    assert row(family) == there


def test_writers_and_backends():
    assert {"BasicWriter", "PoseWriter"} <= row("writers")
    assert row("writers") >= set(rep.writers.get_writers())
    assert row("backends") >= set(backends.registered.names()) - {"S3Backend"}
    assert words(section("Annotators")) >= {*writers.UNSUPPORTED, "S3Backend"}
    assert all(hasattr(rep, name) for name in row("top level"))


def test_annotators():
    """Those of the tests, if any are registered now, have no place there."""
    there, missing = section("Annotators").split("These are known and raise", 1)
    own = {name for name in catalogue.kinds if catalogue.kinds.get(name).compute.__module__.startswith("usdsdg.")}
    assert words(there) - {"annotators.get(name)", "AnnotatorRegistry.get_annotator(name)"} == own - {"skeleton_data"}
    assert {*catalogue.UNSUPPORTED, "skeleton_data"} <= words(missing)
    assert not words(missing) & (own - {"skeleton_data"})


def test_settings():
    told = {word.rstrip(",") for word in words(section("Settings with a meaning")) if word.startswith("/")}
    assert told == set(settings.DEFAULTS)
