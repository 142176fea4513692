"""The contract of the family: life, triggers, metadata, registry."""

import json
import warnings
from types import SimpleNamespace

import pytest

from tests.annotators.ray_caster import make_frame
from tests.annotators.scenes import street
from usdsdg import annotators, get, writers
from usdsdg.capture.requests import Requests
from usdsdg.errors import (
    AnnotatorRegistryError,
    BadPrim,
    InvalidWriterError,
    Unsupported,
    UsdsdgWarning,
    WriterError,
    WriterRegistryError,
    forget_warnings,
)
from usdsdg.session import render_products
from usdsdg.writers.registry import WriterRegistry

PRODUCT = "/Render/HydraTextures/rp1"


class Recorder(writers.Writer):
    """A user's writer, which does not call super().__init__()."""

    version = "1.2.3"

    def __init__(self, output_dir=None):
        self.backend = writers.DiskBackend(output_dir) if output_dir else None
        self.annotators.append("rgb")
        self.annotators.append(annotators.get("occlusion"))
        self.seen = []

    def write(self, data):
        self.seen.append(data)


@pytest.fixture(autouse=True)
def registered():
    writers.register_writer(Recorder, category="tests")
    yield
    writers.unregister_writer("Recorder")


@pytest.fixture
def recorder():
    writer = writers.get("Recorder")
    writer.initialize()
    return writer


def test_arguments_without_names_are_refused_with_their_names(recorder, tmp_path):
    remedy = r"takes arguments by name only, as in initialize\(output_dir='out'\)"
    with pytest.raises(WriterError, match=f"Recorder: .*{remedy}"):
        recorder.initialize("out")
    with pytest.raises(WriterError, match=f"CocoWriter: .*{remedy}"):  # which has an initialize of its own
        writers.get("CocoWriter").initialize("out")
    for give in (writers.get, WriterRegistry.get):
        with pytest.raises(WriterError, match="Recorder: init_params is 'out'; expected a dictionary"):
            give("Recorder", "out")
    with pytest.raises(WriterError, match="Recorder: init_params is 'out'; expected a dictionary"):
        WriterRegistry.attach("Recorder", PRODUCT, "out")


def test_the_registry_makes_instances_without_init():
    writer = writers.get("Recorder")
    assert not hasattr(writer, "seen")
    writer.initialize()
    assert writer.seen == []
    writer.initialize()
    assert len(writer.annotators) == 2, "initialize starts from the class's annotators again"
    assert Recorder.annotators == []


def test_init_params_and_render_products_initialize_and_attach():
    writer = writers.get("Recorder", init_params={}, render_products=[PRODUCT])
    assert writers.attached_writers() == (writer,)
    assert writer.render_products == (PRODUCT,)


def test_options_of_a_users_writer_are_checked_by_name():
    with pytest.raises(WriterError, match=r"Recorder has no option 'outdir'.* Did you mean 'output_dir'"):
        writers.get("Recorder").initialize(outdir="x")

    class Needy(Recorder):
        def __init__(self, listener, output_dir=None):
            super().__init__(output_dir)

    with pytest.raises(WriterError, match="Needy needs listener"):
        Needy.__new__(Needy).initialize(output_dir=None)


def test_unknown_names():
    with pytest.raises(WriterRegistryError, match="Did you mean 'PoseWriter'"):
        writers.get("PoseWritter")
    with pytest.raises(WriterRegistryError, match="not a subclass"):
        writers.register_writer(dict)


def test_categories():
    assert set(writers.get_writers("tests")) == {"Recorder"}
    assert {"BasicWriter", "PoseWriter", "Recorder"} <= set(writers.get_writers())


@pytest.mark.parametrize(
    "handle", [PRODUCT, [PRODUCT], SimpleNamespace(path=PRODUCT), (SimpleNamespace(path=PRODUCT),)]
)
def test_attach_and_detach(recorder, handle):
    recorder.attach(handle)
    assert writers.attached_writers() == (recorder,)
    assert [a.get_name() for a in recorder.annotators_of(PRODUCT)] == ["rgb", "occlusion"]
    recorder.detach()
    assert writers.attached_writers() == ()
    assert recorder.render_products == ()


def test_a_writer_that_was_not_initialized_cannot_be_attached():
    with pytest.raises(WriterError, match=r"initialize.*such as rgb=True.*lists them in self\.annotators"):
        writers.get("Recorder").attach(PRODUCT)


def test_a_render_product_that_does_not_exist_cannot_be_attached_to(recorder):
    with pytest.raises(BadPrim, match=r"no render product /Render/HydraTextures/rp2.* did you mean .*/rp1"):
        recorder.attach([PRODUCT, "/Render/HydraTextures/rp2"])
    assert writers.attached_writers() == ()


def test_a_product_that_is_destroyed_while_attached_is_announced(recorder):
    recorder.attach(PRODUCT)
    render_products.product_at(PRODUCT).destroy()
    forget_warnings()
    with pytest.warns(UsdsdgWarning, match=f"Recorder is attached to {PRODUCT}, which has been destroyed"):
        Requests.collect(0)
    recorder.detach()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Requests.collect(0)


def test_an_unknown_annotator_is_named_when_attaching(recorder):
    recorder.annotators.append("rgbb")
    with pytest.raises(AnnotatorRegistryError, match="'rgbb'"):
        recorder.attach(PRODUCT)


def test_triggers(recorder):
    answers = [True, False]
    item = SimpleNamespace(trigger=SimpleNamespace(executions=0))

    recorder.attach(PRODUCT)
    assert recorder.is_due()
    recorder.attach(PRODUCT, trigger=lambda: answers.pop(0))
    assert recorder.is_due()
    assert not recorder.is_due()
    recorder.attach(PRODUCT, trigger=item)
    assert not recorder.is_due()
    item.trigger.executions = 1
    assert recorder.is_due()
    recorder.receive({})
    assert not recorder.is_due()
    with pytest.raises(Unsupported, match="OgnOnTime"):
        recorder.attach(PRODUCT, trigger="omni.replicator.core.OgnOnTime")
    with pytest.raises(WriterError, match="no writer trigger"):
        recorder.attach(PRODUCT, trigger=42)


def test_without_a_trigger_only_scheduled_frames_are_written(recorder):
    recorder.attach(PRODUCT, trigger=None)
    assert not recorder.is_due()
    recorder.schedule_write()
    assert recorder.is_due()
    recorder.receive({"x": 1})
    assert not recorder.is_due()
    assert recorder.get_data() == {"x": 1}
    assert recorder.num_written == 1


def test_what_never_fires_is_no_trigger(recorder):
    with pytest.raises(WriterError, match="is no trigger and never fires"):
        recorder.attach(PRODUCT, trigger=get.prims())
    with pytest.raises(WriterError, match="is no writer trigger"):
        recorder.attach(PRODUCT, trigger=5)
    with pytest.raises(Unsupported, match="'OgnOnFram': there is no OmniGraph; give a function, or"):
        recorder.attach(PRODUCT, trigger="OgnOnFram")


def test_metadata_is_written_once_before_the_first_frame(tmp_path):
    writers.set_global_seed(77)
    try:
        writer = writers.get("Recorder", init_params={"output_dir": str(tmp_path)})
        writer.metadata["extra"] = 1
        writer.attach(PRODUCT)
        writer.receive({})
        writer.receive({})
        writer.backend.wait_until_done()
    finally:
        writers.set_global_seed(None)
    text = (tmp_path / "metadata.txt").read_text()
    assert json.loads(text) == {"name": "Recorder", "version": "1.2.3", "replicator_global_seed:": 77, "extra": 1}
    assert "\n" not in text


def test_what_a_writer_tells_of_itself(recorder):
    assert recorder.get_metadata() == {"name": "Recorder", "version": "1.2.3", "replicator_global_seed:": None}
    assert recorder.metadata == recorder.get_metadata()
    assert (recorder.get_data(), recorder.num_written) == (None, 0)
    with pytest.raises(InvalidWriterError, match="Recorder is attached to no render product"):
        recorder.get_node()
    recorder.attach(PRODUCT)
    assert recorder.get_node() is recorder
    for index in range(2):
        recorder.receive({"index": index})
    assert (recorder.get_data(), recorder.num_written) == ({"index": 1}, 2)
    recorder.reset()
    assert recorder.num_written == 0
    read = recorder.get_annotators()
    assert [(name, each.template_name) for name, each in read.items()] == [("rgb", "rgb"), ("occlusion", "occlusion")]
    recorder.detach()
    assert recorder.get_data() is None


def test_metadata_that_was_asked_for_before_the_run_has_the_seed_of_the_run(recorder):
    recorder.metadata["extra"] = 1
    assert recorder.get_metadata()["replicator_global_seed:"] is None
    writers.set_global_seed(5)
    try:
        facts = {"name": "Recorder", "version": "1.2.3", "replicator_global_seed:": 5, "extra": 1}
        assert recorder.get_metadata() == recorder.metadata == facts
    finally:
        writers.set_global_seed(None)


def test_a_writer_attached_by_name_takes_parameters_and_a_trigger(tmp_path):
    WriterRegistry.attach("Recorder", PRODUCT, {"output_dir": str(tmp_path)}, trigger=None)
    writer = WriterRegistry.get_attached_writers()["Recorder"]
    assert writer.backend.output_dir == str(tmp_path)
    assert not writer.is_due()
    with pytest.raises(WriterRegistryError, match="Did you mean 'Recorder'"):
        WriterRegistry.attach("Recordr", PRODUCT)
    with pytest.raises(WriterError, match=r"Recorder has no option 'outputdir'\. Did you mean 'output_dir'"):
        WriterRegistry.attach("Recorder", PRODUCT, {"outputdir": str(tmp_path)})


def test_a_users_writer_reads_the_legacy_payload(recorder):
    frame = make_frame(street(), (16, 12))
    recorder.attach(PRODUCT)
    recorder.receive(annotators.build_payload(recorder, {PRODUCT: frame}))
    assert recorder.seen[0]["rgb"].shape == (12, 16, 4)


def test_annotators_can_be_found_and_added(recorder):
    recorder.add_annotator("normals", name="n")
    assert recorder.get_annotator("n").template_name == "normals"
    assert recorder.get_annotator("oclusion") is None


def test_the_registry_knows_what_is_attached(recorder):
    recorder.attach(PRODUCT)
    assert WriterRegistry.get_attached_writers() == {"Recorder": recorder}
    assert WriterRegistry.get_attached_writer("Recorder") is recorder
    assert WriterRegistry.get_writer_render_products() == {(PRODUCT,)}
    assert WriterRegistry.get_annotators(PRODUCT) == set(recorder.annotators)
    with pytest.raises(WriterRegistryError, match=r"No writer is attached to /Render/Other, so none .* 'Recorder'"):
        WriterRegistry.get_attached_writer("Recorder", "/Render/Other")
    assert WriterRegistry.get_attached_writer("BasicWriter", PRODUCT) is None
    WriterRegistry.detach("Recorder")
    assert WriterRegistry.get_attached_writers() == {}
    assert WriterRegistry.get_writer_render_products() == set()


def test_the_registry_attaches_instances_as_in_replicator(recorder):
    WriterRegistry.attach(recorder, PRODUCT, None, None)
    assert recorder.render_products == (PRODUCT,)
    assert not recorder.is_due()
    recorder.detach()
    with pytest.raises(WriterRegistryError, match=r"Recorder was given a; call its initialize\(\)"):
        WriterRegistry.attach(recorder, PRODUCT, a=1)
    with pytest.raises(InvalidWriterError, match="3 is no writer"):
        WriterRegistry.attach(3, PRODUCT)
    with pytest.raises(InvalidWriterError, match="int is not a subclass"):
        WriterRegistry.register(int)


def test_one_text_in_place_of_a_list_of_annotators_is_refused(recorder):
    """Its letters are no names."""
    recorder.annotators = "rgb"
    with pytest.raises(WriterError, match="annotators is the text 'rgb'"):
        recorder.attach(PRODUCT)
