"""Functions return the kind of object that the table says: items in the graph families, prims in immediate mode."""

import contextlib

import numpy as np
import pytest
from PIL import Image
from pxr import Usd, UsdGeom

import usdsdg as rep
from tests.contracts import gaps, mirror
from usdsdg.session.render_products import HydraTexture
from usdsdg.session.settings.store import DEFAULTS, get_settings
from usdsdg.session.stage_context import new_stage

IS = {
    "annotator": lambda value: isinstance(value, rep.annotators.Annotator),
    "augmentation": lambda value: isinstance(value, rep.annotators.Augmentation),
    "backend": lambda value: isinstance(value, rep.backends.BaseBackend),
    "bool": lambda value: isinstance(value, bool),
    "callback": lambda value: hasattr(value, "unregister"),
    "context": lambda value: isinstance(value, contextlib.AbstractContextManager),
    "item": lambda value: isinstance(value, rep.utils.ReplicatorItem),
    "list": lambda value: isinstance(value, list),
    "none": lambda value: value is None,
    "number": lambda value: isinstance(value, (int, float)),
    "prim": lambda value: isinstance(value, Usd.Prim),
    "product": lambda value: isinstance(value, HydraTexture),
    "stage": lambda value: isinstance(value, Usd.Stage),
    "status": lambda value: isinstance(value, rep.orchestrator.Status),
    "writer": lambda value: isinstance(value, rep.Writer),
}
CUBE, MESH, CAMERA, MATERIAL = "/World/cube", "/World/mesh", "/World/camera", "/World/material"
PRIMS = {"input_prims": MESH}
AUGMENTATION = lambda data_in: data_in  # noqa: E731

# Arguments by function; functions that are not listed are called without arguments.
ARGUMENTS = {
    "create.stereo_camera": (1.0,),
    "create.render_product": (CAMERA, (8, 8)),
    "create.render_product_tiled": ([CAMERA], (8, 8)),
    "create.from_usd": ("{usd}",),
    "create.from_dir": ("{folder}",),
    "create.group": ([CUBE],),
    "create.projection_material": (CUBE,),
    "get.prim_at_path": (CUBE,),
    "distribution.uniform": (0, 1),
    "distribution.normal": (0, 1),
    "distribution.log_uniform": (1, 2),
    "distribution.choice": ([1, 2],),
    "distribution.sequence": ([1, 2],),
    "distribution.combine": ([1, 2],),
    "modify.semantics": ([("class", "cube")], CUBE),
    "modify.pose": ((1, 2, 3),),
    "modify.pose_camera_relative": (CAMERA, "{product}", 3.0),
    "modify.pose_orbit": ((0, 0, 0), 3.0, 10.0, 20.0),
    "modify.attribute": ("size", 2.0),
    "modify.visibility": (True,),
    "modify.variant": ("kind", "a"),
    "modify.material": (MATERIAL,),
    "modify.animation": ("/World/walk",),
    "modify.timeline": (1.0, "time"),
    "modify.time": (1.0,),
    "modify.frame": (1,),
    "randomizer.scatter_2d": (MESH,),
    "randomizer.scatter_3d": (MESH,),
    "randomizer.materials": ([MATERIAL],),
    "randomizer.instantiate": (["{usd}"], 1),
    "randomizer.texture": (["{png}"],),
    "randomizer.color": ([(1, 0, 0)],),
    "trigger.on_custom_event": ("go",),
    "trigger.on_condition": (lambda: True,),
    "orchestrator.register_status_callback": (lambda status: None,),
    "orchestrator.set_next_rt_subframes": (1,),
    "orchestrator.set_minimum_next_rt_subframes": (1,),
    "orchestrator.set_capture_on_play": (False,),
    "settings.set_physx_timestep": (1 / 60,),
    "settings.set_stage_meters_per_unit": (1.0,),
    "settings.set_stage_up_axis": ("Z",),
    "utils.find_prims": ([CUBE],),
    "utils.get_non_xform_prims": ([CUBE],),
    "utils.get_node_targets": ("{item}", "inputs:prims"),
    "utils.get_prim_variant_values": ("/World/shelf", "kind"),
    "utils.get_prims_from_paths": ([CUBE],),
    "utils.get_usd_files": ("{folder}",),
    "utils.send_og_event": ("go",),
    "annotators.get": ("rgb",),
    "annotators.get_augmentation": ("rgba_to_rgb",),
    "annotators.augment": ("rgb", AUGMENTATION),
    "annotators.augment_compose": ("rgb", [AUGMENTATION]),
    "AnnotatorRegistry.get_annotator": ("rgb",),
    "writers.get": ("BasicWriter",),
    "WriterRegistry.get": ("BasicWriter",),
    "backends.get": ("DiskBackend",),
    "functional.create.clone": (CUBE,),
    "functional.create.reference": ("{usd}",),
    "functional.create.material": ("OmniPBR.mdl",),
    "functional.create_batch.clone": (CUBE,),
    "functional.create_batch.reference": ("{usd}",),
    "functional.create_batch.material": ("OmniPBR.mdl",),
    "functional.get.prim_at_path": ("{stage}", CUBE),
    "functional.get.prim_at_paths": ("{stage}", CUBE),
}
# Functions that act on prims get them as an argument, as in scripts outside of a `with` block.
ON_PRIMS = ("modify.", "randomizer.", "physics.", "create.projection_material", "create.mesh_decal")
NOT_ON_PRIMS = ("modify.semantics", "modify.timeline", "modify.time", "modify.frame", "randomizer.instantiate")
# Methods need an object, and the other two would affect other tests.
NOT_CALLED = (
    "HydraTexture.", "Annotator.", "Augmentation.", "BaseBackend.", "ReplicatorItem.", "Writer.", "ReplicatorRNG.",
    "open_stage", "set_global_seed",
)  # fmt: skip


def called() -> list[str]:
    # By the lists, which other tests compare: to look at all names would take each process that collects seconds.
    lacking = {*gaps.listed(gaps.MISSING), *gaps.listed(gaps.UNBUILT)}
    built = [path for path, name in mirror.names().items() if name.returns and path not in lacking]
    return [path for path in built if not any(word in path for word in NOT_CALLED)]


@pytest.fixture
def given(tmp_path):
    """Values for the words in braces: a new stage with a few prims, and files; settings are restored afterward."""
    settings = get_settings()
    before = {key: settings.get(key) for key in settings.changed()}
    stage = new_stage()
    for name, kind in (
        ("cube", "Cube"),
        ("camera", "Camera"),
        ("material", "Material"),
        ("shelf", "Xform"),
        ("walk", "SkelAnimation"),
    ):
        stage.DefinePrim(f"/World/{name}", kind)
    plane = UsdGeom.Mesh.Define(stage, MESH)
    plane.CreatePointsAttr([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
    plane.CreateFaceVertexCountsAttr([4])
    plane.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    for path in ("/World/shelf", CUBE):
        variants = stage.GetPrimAtPath(path).GetVariantSets().AddVariantSet("kind")
        variants.AddVariant("a")
        variants.SetVariantSelection("a")
    usd = str(tmp_path / "thing.usda")
    thing = Usd.Stage.CreateNew(usd)
    thing.SetDefaultPrim(thing.DefinePrim("/Thing", "Cube"))
    thing.Save()
    Image.fromarray(np.zeros((2, 2, 3), np.uint8)).save(tmp_path / "picture.png")
    yield {
        "usd": usd,
        "png": str(tmp_path / "picture.png"),
        "folder": str(tmp_path),
        "stage": stage,
        "product": rep.create.render_product(CAMERA, (8, 8)),
        "item": rep.create.group([CUBE]),
    }
    for key in settings.changed():
        value = before.get(key, DEFAULTS.get(key))
        settings.set(key, value) if value is not None else settings.destroy_item(key)
    new_stage()


def filled(value, given):
    """Return `value` with the words in braces replaced."""
    if isinstance(value, (list, tuple)):
        return type(value)(filled(each, given) for each in value)
    return given[value[1:-1]] if isinstance(value, str) and value.startswith("{") else value


@pytest.mark.parametrize("path", called())
def test_a_function_returns_the_kind_of_the_table(path, given):
    function = rep
    for part in path.split("."):
        function = getattr(function, part)
    arguments = filled(ARGUMENTS.get(path, ()), given)
    options = dict(PRIMS) if path.startswith(ON_PRIMS) and path not in NOT_ON_PRIMS else {}
    if path.startswith("functional.get.") and not arguments:
        arguments = (given["stage"],)
    if path.startswith("functional.create_batch."):
        options["count"] = 2
    assert IS[mirror.names()[path].returns](function(*arguments, **options))
