"""Writers as people write them for Isaac Sim: old and new backends, augmented annotators, triggers, named draws."""

import io
import json
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
import warp as wp
from PIL import Image
from pxr import Usd, UsdGeom

import usdsdg as rep
from tests.annotators.ray_caster import RayCaster, add_cube, known, make_frame
from tests.annotators.scenes import add_camera, street
from tests.dataset_files import data_names
from usdsdg import AnnotatorRegistry, annotators, orchestrator, writers
from usdsdg.compat.omni.syntheticdata import SyntheticData
from usdsdg.errors import AnnotatorRegistryError, AugmentationError, BadPrim, WriterError
from usdsdg.session import engines
from usdsdg.session.session import current
from usdsdg.session.settings.store import get_settings
from usdsdg.session.stage_context import current_stage
from usdsdg.writers import BackendDispatch, Writer, WriterRegistry
from usdsdg.writers.files import write_image

PRODUCT = "/Render/HydraTextures/rp1"


class BoxWriter(Writer):
    """After the online documentation's example of a custom writer, in the form of 4.2."""

    def __init__(self, output_dir, rgb=True, bounding_box_2d_tight=False, image_output_format="png"):
        self._output_dir = output_dir
        self._backend = BackendDispatch({"paths": {"out_dir": output_dir}})
        self.backend = self._backend
        self._frame_id = 0
        self._image_output_format = image_output_format
        self.annotators = []
        if rgb:
            self.annotators.append(AnnotatorRegistry.get_annotator("rgb"))
        if bounding_box_2d_tight:
            self.annotators.append(
                AnnotatorRegistry.get_annotator("bounding_box_2d_tight", init_params={"semanticTypes": ["class"]})
            )

    def write(self, data):
        if "rgb" in data and "bounding_box_2d_tight" in data:
            boxes = data["bounding_box_2d_tight"]["data"]
            labels = data["bounding_box_2d_tight"]["info"]["idToLabels"]
            found = {labels[str(box["semanticId"])]["class"]: [int(box["x_min"]), int(box["x_max"])] for box in boxes}
            data["rgb"][:, :, 0] = 0
            self._backend.write_image(f"rgb_{self._frame_id}.{self._image_output_format}", data["rgb"])
            text = io.BytesIO()
            text.write(json.dumps(found).encode())
            self._backend.write_blob(f"boxes_{self._frame_id}.json", text.getvalue())
        self._frame_id += 1


class ColorWriter(Writer):
    """In the form of 5.x: a layout, a backend by name, jobs for it."""

    version = "0.0.1"

    def __init__(self, output_dir, extra=None):
        self.data_structure = "renderProduct"
        self.backend = rep.backends.get("DiskBackend", init_params={"output_dir": output_dir})
        self.annotators = ["rgb", rep.annotators.get("distance_to_camera")]
        self.ended = 0
        self.payloads = []

    def write(self, data):
        self.payloads.append(data)
        for product, seen in data["renderProducts"].items():
            name = f"{product}_{self.num_written}.png"
            self.backend.schedule(write_image, data=seen["rgb"]["data"], path=name)

    def on_final_frame(self):
        self.ended += 1


class StandIn(RayCaster):
    """The tests' ray caster where the product has its renderer."""

    def __init__(self):
        super().__init__(current_stage())

    time = Usd.TimeCode.Default()
    device = "cpu"

    def finish(self):
        """Do nothing: there is no device that still works."""

    def look_at_files(self):
        """Do nothing: there are no textures."""

    def sync(self, time):
        self.gprims = RayCaster(current_stage()).gprims

    def places(self, paths):
        """Know no transforms: the reader of labels asks USD for them."""
        return np.zeros(0, int), np.zeros((0, 4, 4))

    def labels_of(self, views, aovs, *, faces, fetched):
        return [{name: aov for name, aov in self.labels(view).items() if name in aovs} for view in views]

    def labels_and_masks(self, views, aovs, groups, *, faces, fetched):
        return self.labels_of(views, aovs, faces=faces, fetched=fetched), [
            self.pixel_masks(view, groups) for view in views
        ]

    def new_films(self, count, width, height):
        return [{} for _ in range(count)]

    def accumulate_all(self, films, views, **_):
        for film, view in zip(films, views, strict=True):
            film["view"] = view

    def develop_all(self, films, tone, *, fetched):
        return [{name: self.labels(film["view"])[name] for name in ("LdrColor", "HdrColor")} for film in films]


@pytest.fixture
def product(stage, monkeypatch):
    """A product of a stage with a labeled cube, drawn by the tests' ray caster."""
    get_settings().set("/app/player/playSimulations", False)
    add_cube(current_stage(), "/World/Box", "box")
    camera = add_camera(current_stage(), "/World/Camera", (0, -4, 1), (0, 0, 0))
    monkeypatch.setattr(current().engines, "renderer", StandIn())
    monkeypatch.setattr(engines, "quiet_warp", lambda: None)
    return rep.create.render_product(camera, (32, 24))


@pytest.fixture(autouse=True)
def registered():
    for writer in (BoxWriter, ColorWriter):
        WriterRegistry.register(writer)
    yield
    for writer in (BoxWriter, ColorWriter):
        WriterRegistry.unregister(writer.__name__)


def test_the_documented_custom_writer_writes_its_files(product, tmp_path):
    writer = WriterRegistry.get("BoxWriter")
    writer.initialize(output_dir=str(tmp_path), rgb=True, bounding_box_2d_tight=True)
    other = WriterRegistry.get("ColorWriter", init_params={"output_dir": str(tmp_path / "other")})
    for each in (writer, other):
        each.attach([product])
    for _ in range(2):
        orchestrator.step()
    orchestrator.wait_until_complete()
    names = {name.split("/")[0] for name in data_names(tmp_path)}
    assert names == {"rgb_0.png", "rgb_1.png", "boxes_0.json", "boxes_1.json", "metadata.txt", "other"}
    low, high = json.loads((tmp_path / "boxes_1.json").read_text())["box"]
    assert 8 < low < high < 24
    assert not np.asarray(Image.open(tmp_path / "rgb_0.png"))[..., 0].any()
    name = other.payloads[0]["renderProducts"].keys()
    shown = np.asarray(Image.open(tmp_path / "other" / f"{next(iter(name))}_0.png"))
    assert shown[..., 0].any(), "one writer's changes are its own"


def test_the_last_frame_is_told_once(product, tmp_path):
    writer = WriterRegistry.get("ColorWriter", {"output_dir": str(tmp_path)}, [product])
    orchestrator.step()
    assert writer.ended == 0
    orchestrator.wait_until_complete()
    orchestrator.wait_until_complete()
    assert writer.ended == 1


class SyncedWriter(BoxWriter):
    """Ends as writers for older versions do, whose files are all there then."""

    def on_final_frame(self):
        self.backend.sync_pending_paths()
        self.found = sorted(path.name for path in Path(self._output_dir).glob("rgb_*.png"))


def test_a_writer_that_syncs_its_backend_at_the_last_frame_finds_all_its_files(product, tmp_path):
    writer = SyncedWriter(str(tmp_path), bounding_box_2d_tight=True)
    writer.attach([product])
    for _ in range(3):
        orchestrator.step()
    orchestrator.wait_until_complete()
    assert writer.found == ["rgb_0.png", "rgb_1.png", "rgb_2.png"]


@pytest.mark.parametrize(
    ("before", "predicate", "options", "expected"),
    [
        (False, "class:!box", {}, {"ball"}),
        (False, "class:box", {}, {"box"}),
        (True, "class:!box", {}, {"box", "ball"}),
        (False, "class:!box", {"semantic_types": ["class"]}, {"box", "ball"}),
    ],
)
def test_a_filter_that_a_script_sets_after_a_writer_without_one_applies_to_it(
    product, tmp_path, before, predicate, options, expected
):
    add_cube(current_stage(), "/World/Ball", "ball")
    UsdGeom.XformCommonAPI(current_stage().GetPrimAtPath("/World/Ball")).SetTranslate((1.2, 0, 0))
    if before:
        SyntheticData.Get().set_instance_mapping_semantic_filter(predicate)
    writer = WriterRegistry.get("BasicWriter")
    writer.initialize(output_dir=str(tmp_path), bounding_box_2d_tight=True, semantic_segmentation=True, **options)
    if not before:
        SyntheticData.Get().set_instance_mapping_semantic_filter(predicate)
    writer.attach([product])
    orchestrator.step()
    orchestrator.wait_until_complete()
    boxes = json.loads((tmp_path / "bounding_box_2d_tight_labels_0000.json").read_text())
    pixels = json.loads((tmp_path / "semantic_segmentation_labels_0000.json").read_text())
    assert {each["class"] for each in boxes.values()} == expected
    assert {each["class"] for each in pixels.values()} - {"BACKGROUND", "UNLABELLED"} == expected


@pytest.mark.parametrize("how", ["callable", "none", "item"])
def test_a_trigger_says_which_frames_are_written(product, tmp_path, how):
    wanted = iter([False, True, False, True])
    trigger = {
        "callable": lambda: lambda: next(wanted),
        "none": lambda: None,
        "item": lambda: rep.trigger.on_custom_event("go"),
    }[how]()
    writer = WriterRegistry.get("ColorWriter", {"output_dir": str(tmp_path)})
    writer.attach([product], trigger=trigger)
    numbers = []
    for frame in range(4):
        if frame % 2:
            writer.schedule_write() if how == "none" else None
            rep.utils.send_og_event("go") if how == "item" else None
        orchestrator.step()
        numbers.append(len(writer.payloads))
    assert numbers == [0, 1, 1, 2]
    assert [payload["swhFrameNumber"] for payload in writer.payloads] == [1, 3]


def test_several_products_come_in_one_payload_and_can_be_switched_off(product, tmp_path):
    second = rep.create.render_product("/World/Camera", (16, 12), name="second")
    writer = WriterRegistry.get("ColorWriter", {"output_dir": str(tmp_path)})
    writer.attach([product, second])
    orchestrator.step()
    product.hydra_texture.set_updates_enabled(False)
    orchestrator.step()
    writer.detach()
    orchestrator.step()
    first, last = (payload["renderProducts"] for payload in writer.payloads)
    assert set(first) == {product.name, "second"}
    assert set(last) == {"second"}
    assert first["second"]["rgb"]["data"].shape == (12, 16, 4)
    assert first["second"]["camera"] == "/World/Camera"
    np.testing.assert_array_equal(first["second"]["resolution"], [16, 12])


def test_payloads_tell_of_named_triggers_and_draws(product, tmp_path):
    writer = WriterRegistry.get("ColorWriter", {"output_dir": str(tmp_path)}, [product])
    box = "/World/Box"
    with rep.trigger.on_frame(name="on-frame"):
        rep.modify.attribute("size", rep.distribution.uniform(0.5, 1.0, name="size"), input_prims=box)
    with rep.trigger.on_frame(interval=2):
        rep.modify.visibility(True, input_prims=box)
    with rep.trigger.on_custom_event("event"):
        rep.modify.visibility(True, input_prims=box)
    rep.modify.attribute("ratio", rep.distribution.uniform(0.0, 1.0, name="once"), "double", input_prims=box)
    counts = [{"on-frame": 0, "on_frame": 0}, {"on-frame": 1, "on_frame": 0}, {"on-frame": 2, "on_frame": 1}]
    for expected in counts:
        orchestrator.step()
        payload, box_prim = writer.payloads[-1], current_stage().GetPrimAtPath(box)
        assert payload["trigger_outputs"] == expected, "previews are no firings"
        named = payload["named_outputs"]
        assert {name: named[name] for name in expected} == {name: {"execCounts": n} for name, n in expected.items()}
        for name, attribute in (("size", "size"), ("once", "ratio")):
            assert named[name]["samples"][0] == pytest.approx(box_prim.GetAttribute(attribute).Get(), rel=1e-6)
            assert payload["distribution_outputs"][name] is named[name]["samples"]
        assert set(named) == {"on-frame", "on_frame", "size", "once"}


@pytest.mark.parametrize("is_triggered", [True, False])
def test_named_draws_inside_of_combine_are_told_too(product, tmp_path, is_triggered):
    writer = WriterRegistry.get("ColorWriter", {"output_dir": str(tmp_path)}, [product])
    x, z = rep.distribution.uniform(-1.0, 1.0, name="x"), rep.distribution.sequence([1.0, 2.0, 3.0], name="z")
    inner = rep.distribution.combine([z, rep.distribution.normal(0.0, 1.0)], name="inner")
    with rep.trigger.on_frame() if is_triggered else nullcontext():
        rep.modify.pose(position=rep.distribution.combine([x, inner]), input_prims="/World/Box")
    for _ in range(2):
        orchestrator.step()
        place = current_stage().GetPrimAtPath("/World/Box").GetAttribute("xformOp:translate").Get()
        drawn = writer.payloads[-1]["distribution_outputs"]
        assert set(drawn) == {"x", "z", "inner"}
        assert (*drawn["x"], *drawn["z"]) == pytest.approx(place[:2], rel=1e-6)
        assert drawn["inner"][0] == pytest.approx(place[1:], rel=1e-6)


@pytest.mark.parametrize("is_triggered", [True, False])
@pytest.mark.parametrize("function", ["choice", "sequence"])
def test_named_draws_that_a_list_holds_are_told_for_the_prims_that_took_them(product, tmp_path, is_triggered, function):
    writer = WriterRegistry.get("ColorWriter", {"output_dir": str(tmp_path)}, [product])
    near = rep.distribution.uniform((0, 0, 0), (1, 1, 1), name="near")
    axes = [rep.distribution.normal(10.0, 1.0, name="x"), 11.0, 12.0]
    place = getattr(rep.distribution, function)([near, rep.distribution.combine(axes, name="far")])
    boxes = rep.create.cube(count=8)
    with rep.trigger.on_frame() if is_triggered else nullcontext(), boxes:
        rep.modify.pose(position=place)
    for _ in range(3):
        orchestrator.step()
        drawn = writer.payloads[-1]["distribution_outputs"]
        assert set(drawn) == {"near", "far", "x"}
        places = [each.GetAttribute("xformOp:translate").Get() for each in boxes.get_output_prims()["prims"]]
        for row, at in enumerate(places):
            took, other = ("near", "far") if at[0] < 5 else ("far", "near")
            assert drawn[took][row] == pytest.approx(tuple(at), rel=1e-6)
            assert drawn[other][row] is None
            assert drawn["x"][row] == (pytest.approx(at[0], rel=1e-6) if took == "far" else None)


@pytest.mark.parametrize("is_triggered", [True, False])
def test_a_named_pattern_over_prims_is_told_as_it_was_drawn(product, tmp_path, is_triggered):
    writer = WriterRegistry.get("ColorWriter", {"output_dir": str(tmp_path)}, [product])
    boxes = rep.create.cube(count=3)
    shown = rep.distribution.choice([[True, False, False], [False, True, True], [True, True, False]], name="shown")
    with rep.trigger.on_frame() if is_triggered else nullcontext(), boxes:
        rep.modify.visibility(shown)
    for _ in range(3):
        orchestrator.step()
        seen = [each.GetAttribute("visibility").Get() != "invisible" for each in boxes.get_output_prims()["prims"]]
        assert list(writer.payloads[-1]["distribution_outputs"]["shown"]) == seen
        assert list(shown.get_output("samples")) == seen


def test_common_keys_tell_time_triggers_and_named_draws(product, tmp_path):
    writer = WriterRegistry.get("ColorWriter", {"output_dir": str(tmp_path)}, [product])
    with rep.trigger.on_frame():
        rep.modify.attribute("size", rep.distribution.uniform(0.5, 1.0, name="size"), input_prims="/World/Box")
    for _ in range(3):
        orchestrator.step()
        size = current_stage().GetPrimAtPath("/World/Box").GetAttribute("size").Get()
        (drawn,) = writer.payloads[-1]["distribution_outputs"]["size"]
        assert drawn == pytest.approx(size, rel=1e-6)
    assert {"swhFrameNumber", "reference_time", "distribution_outputs", "trigger_outputs", "named_outputs"} <= set(
        writer.get_data()
    )
    times = [numerator / denominator for numerator, denominator in (each["reference_time"] for each in writer.payloads)]
    assert times == pytest.approx([0.0, 1 / 60, 2 / 60], abs=1e-6), "steps play the timeline"


def test_augmented_annotators_of_a_writer(product, tmp_path):
    writer = WriterRegistry.get("ColorWriter", {"output_dir": str(tmp_path)})
    hsv = annotators.get("rgb").augment_compose(["RgbToHsv", lambda data_in: data_in // 2, "HsvToRgb"], name="rgb")
    writer.add_annotator(hsv)
    writer.augment_annotator("distance_to_camera", lambda data_in, scale: data_in * scale, scale=10.0)
    writer.add_annotator("normals", name="surface")
    assert list(writer.get_annotators()) == ["rgb", "distance_to_camera", "surface"]
    writer.attach([product])
    plain = annotators.get("distance_to_camera").attach(product)
    orchestrator.step()
    (seen,) = writer.payloads[0]["renderProducts"].values()
    depth = plain.get_data()
    np.testing.assert_allclose(seen["distance_to_camera"]["data"][depth < 1e9], depth[depth < 1e9] * 10)
    assert seen["surface"]["data"].shape == (24, 32, 4)
    # Replicator's HsvToRgb is a Warp kernel, of which writers receive Warp arrays.
    assert isinstance(seen["rgb"]["data"], wp.array)
    assert seen["rgb"]["data"].numpy().max() <= 128
    plain.detach()


def test_what_cannot_be_read_or_augmented_is_told(tmp_path):
    writer = WriterRegistry.get("ColorWriter", {"output_dir": str(tmp_path)})
    with pytest.raises(AnnotatorRegistryError, match="Did you mean 'normals'"):
        writer.add_annotator("normal")
    with pytest.raises(WriterError, match="3 is no annotator"):
        writer.add_annotator(3)
    with pytest.raises(WriterError, match="reads no annotator 'depth'"):
        writer.augment_annotator("depth", "Sobel")
    with pytest.raises(AugmentationError, match=r"'Pixelate'\. Did you mean 'Pixellate'"):
        writer.augment_annotator("rgb", "Pixelate")
    writer.annotators = [3]
    with pytest.raises(WriterError, match="3 is no annotator"):
        writer.attach(PRODUCT)


def test_a_layout_that_does_not_exist_is_told_when_attaching(tmp_path):
    writer = WriterRegistry.get("ColorWriter", {"output_dir": str(tmp_path)})
    writer.data_structure = "annotators"
    with pytest.raises(WriterError, match="ColorWriter: data_structure 'annotators' does not exist; it may be legacy"):
        writer.attach(PRODUCT)


def test_a_writers_annotators_give_their_data_while_it_is_attached(tmp_path):
    writer = WriterRegistry.get("ColorWriter", {"output_dir": str(tmp_path)})
    assert writer.get_attached_annotators() == []
    writer.attach(PRODUCT)
    frame = make_frame(street(), (16, 12), product=PRODUCT)
    writer.receive(annotators.build_payload(writer, {PRODUCT: frame}))
    depth = writer.get_attached_annotators()[1]
    np.testing.assert_array_equal(depth.get_data(), frame.aovs["distance_to_camera"])
    assert annotators.attached_annotators() == (), "the writer computes them, nobody else has to"
    writer.detach()
    assert not depth.is_attached


def test_attaching_later_to_other_products_and_waiting_for_it(tmp_path):
    import asyncio

    writer = WriterRegistry.get("ColorWriter", {"output_dir": str(tmp_path)})
    with pytest.raises(BadPrim):
        asyncio.run(writer.attach_async("/Render/HydraTextures/nowhere"))
    asyncio.run(writer.attach_async(PRODUCT))
    assert writer.render_products == (PRODUCT,)
    assert writers.attached_writers() == (writer,)


def test_the_registry_attaches_and_detaches_by_name_and_product(tmp_path):
    known("/Render/HydraTextures/rp2")
    second = "/Render/HydraTextures/rp2"
    WriterRegistry.attach("ColorWriter", [PRODUCT, second], init_params={"output_dir": str(tmp_path)})
    writer = WriterRegistry.get_attached_writer("ColorWriter")
    assert WriterRegistry.get_attached_writers() == {"ColorWriter": writer}
    assert {each.get_name() for each in WriterRegistry.get_annotators(second)} == {"rgb", "distance_to_camera"}
    writer.detach_from(PRODUCT)
    assert WriterRegistry.get_writer_render_products() == {(second,)}
    assert writer.get_annotator("rgb").render_product == second
    WriterRegistry.detach("BoxWriter")
    assert writers.attached_writers() == (writer,)
    WriterRegistry.detach("ColorWriter", second)
    assert writers.attached_writers() == ()
    assert WriterRegistry.get_attached_writer("ColorWriter") is None
    WriterRegistry.attach("ColorWriter", PRODUCT, init_params={"output_dir": str(tmp_path)}, trigger=None)
    WriterRegistry.detach_all()
    assert writers.attached_writers() == ()
