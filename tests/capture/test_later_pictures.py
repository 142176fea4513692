"""Color images that are traced beside the next frame: the same bytes, read only once they are traced."""

import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import usdsdg as rep
from tests.cli.datasets import content
from tests.verify import datasets
from usdsdg import parallel
from usdsdg.capture import later_pictures
from usdsdg.capture.later_pictures import CopiedPictures
from usdsdg.capture.output import WriterOutput
from usdsdg.errors import WriterError
from usdsdg.session import devices, session
from usdsdg.session.session import current
from usdsdg.session.settings.store import get_settings
from usdsdg.session.stage_context import new_stage
from usdsdg.session.timeline import get_timeline
from usdsdg.writers.backends.disk import DiskBackend
from usdsdg.writers.backends.io_queue import THREADS
from usdsdg_render.renderer import WarpRenderer

SIZE = (64, 48)


@pytest.fixture(autouse=True)
def _two_threads_of_a_cpu(monkeypatch) -> Iterator[None]:
    """A GPU needs no thread that traces; `CopiedPictures`, which it has instead, works on a CPU, too."""
    monkeypatch.setattr(later_pictures, "available_threads", lambda: 2)
    before = current().engines.device
    devices.use_device("cpu")
    yield
    current().io_queue.set_threads(THREADS)
    devices.use_device(before)


@pytest.fixture
def started(monkeypatch) -> list[int]:
    """Grows by the frame of each image that is traced later."""
    frames: list[int] = []
    real = WarpRenderer.later

    def later(renderer, work):
        frames.append(current().orchestrator.captures)
        return real(renderer, work)

    monkeypatch.setattr(WarpRenderer, "later", later)
    return frames


@pytest.fixture
def gate(monkeypatch) -> Iterator[threading.Event]:
    """Holds images back, full of other values than they will have, until the event is set."""
    opened = threading.Event()
    real = later_pictures.LaterPictures._trace

    def trace(pictures) -> None:
        for images in pictures.images.values():
            images[later_pictures.COLOR][...] = 123
        assert opened.wait(20)
        real(pictures)

    monkeypatch.setattr(later_pictures.LaterPictures, "_trace", trace)
    yield opened
    opened.set()
    current().io_queue.wait_until_done()


def build_scene(*, falls: bool = False) -> list:
    """A labeled shape that changes in every frame, with light, seen by two cameras."""
    rep.set_global_seed(5)
    ball = rep.create.sphere(position=(0, 0, 1), semantics=[("class", "ball")])
    rep.create.plane(scale=6)
    rep.create.light(light_type="dome", intensity=800)
    if falls:
        with ball:
            rep.physics.collider()
            rep.physics.rigid_body()
    with rep.trigger.on_frame(), ball:
        rep.randomizer.color(rep.distribution.uniform((0, 0, 0), (1, 1, 1)))
        if not falls:
            rep.modify.pose(position=rep.distribution.uniform((-1, -1, 0), (1, 1, 2)))
    return [
        rep.create.render_product(rep.create.camera(position=place, look_at=(0, 0, 1)), SIZE)
        for place in ((0, -6, 2), (5, -4, 3))
    ]


def basic_writer(folder: Path, products: list, **options):
    writer = rep.WriterRegistry.get("BasicWriter")
    writer.initialize(**({"output_dir": str(folder), "rgb": True, "semantic_segmentation": True} | options))
    writer.attach(products)
    return writer


def captured(folder: Path, *, later: bool, falls: bool = False, frames: int = 4, threads: int = 4) -> dict[str, bytes]:
    """Capture frames of a new stage with two writers; return their files."""
    session.restart()
    new_stage()
    get_settings().set(later_pictures.SETTING, later)
    current().io_queue.set_threads(threads)
    products = build_scene(falls=falls)
    basic_writer(folder / "a", products, bounding_box_2d_tight=True)
    basic_writer(folder / "b", products[:1], semantic_segmentation=False, image_output_format="jpg")
    if falls:
        get_timeline().play()
    for _ in range(frames):
        rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    return content(folder)


@pytest.mark.parametrize("falls", [False, True])
def test_files_are_the_same_bytes(tmp_path, stage, started, falls):
    at_once = captured(tmp_path / "x", later=False, falls=falls)
    assert not started
    later = captured(tmp_path / "y", later=True, falls=falls)
    assert started == [1, 2, 3]  # the first image shows that there is light
    assert at_once == later
    assert len({content for name, content in later.items() if name.startswith("b/rgb_")}) == 4


def test_pictures_of_a_device_begin_when_payloads_are_made_and_files_are_the_same_bytes(tmp_path, stage, monkeypatch):
    """The class is that of GPUs; on the CPU it traces at once, in the thread of the capture."""
    done: list[str] = []
    begin, payload, write = CopiedPictures.begin, WriterOutput.payload, WriterOutput.write
    monkeypatch.setattr(later_pictures, "LaterPictures", CopiedPictures)
    monkeypatch.setattr(CopiedPictures, "begin", lambda self: (done.append("begin"), begin(self)))
    monkeypatch.setattr(WriterOutput, "payload", lambda *given: (done.append("payload"), payload(*given))[1])
    monkeypatch.setattr(WriterOutput, "write", lambda *given: (done.append("write"), write(*given))[1])
    copied = captured(tmp_path / "copied", later=True)
    assert done[-5:] == ["payload", "payload", "begin", "write", "write"]
    assert done.count("begin") >= 3
    assert copied == captured(tmp_path / "at_once", later=False)


def test_files_wait_for_pixels_also_without_threads_of_their_own(tmp_path, stage, started):
    at_once = captured(tmp_path / "x", later=False, threads=0)
    assert captured(tmp_path / "y", later=True, threads=0) == at_once
    assert started


def test_the_next_frame_is_evaluated_while_pictures_are_traced(tmp_path, stage, gate, started):
    product = build_scene()[0]
    evaluated: list[int] = []
    rep.orchestrator.get_orchestrator().on_captured(lambda: evaluated.append(len(started)))
    basic_writer(tmp_path, [product])
    gate.set()
    rep.orchestrator.step()
    gate.clear()
    rep.orchestrator.step()  # returns while its image has no pixels yet
    assert evaluated == [0, 1]
    assert not (tmp_path / "rgb_0001.png").exists()
    assert current().tracing is not None
    opener = threading.Timer(0.3, gate.set)
    opener.start()
    rep.orchestrator.step()  # waits only before it changes the scene on the device
    rep.orchestrator.wait_until_complete()
    assert {path.name for path in tmp_path.glob("rgb_*")} == {f"rgb_{k:04d}.png" for k in range(3)}


def test_data_that_a_script_reads_from_the_writer_have_their_pixels(tmp_path, stage, gate, started):
    product = build_scene()[0]
    writer = basic_writer(tmp_path, [product])
    gate.set()
    rep.orchestrator.step()
    gate.clear()
    rep.orchestrator.step()
    threading.Timer(0.2, gate.set).start()
    of_annotator = writer.get_annotator("rgb").get_data()
    payload = writer.get_data()
    assert payload is not None
    (of_payload,) = (each["data"] for each in payload["annotators"]["rgb"].values())
    assert started == [1]
    rep.orchestrator.wait_until_complete()
    on_disk = np.asarray(Image.open(tmp_path / "rgb_0001.png"))
    assert (of_annotator == on_disk).all()
    assert (of_payload == on_disk).all()


class Looking(rep.Writer):
    """Looks at pixels in `write`."""

    def __init__(self) -> None:
        self.annotators = [rep.annotators.get("rgb")]
        self.means: list[float] = []

    def write(self, data) -> None:
        self.means.append(float(data["rgb"][..., :3].mean()))


class Overriding(rep.WriterRegistry.get("BasicWriter").__class__):
    """BasicWriter with a `write` of its own, which looks at pixels."""

    def write(self, data) -> None:
        self.seen = [float(each["data"].mean()) for each in data["annotators"]["rgb"].values()]
        super().write(data)


def with_a_looking_writer(products, folder):
    writer = Looking()
    writer.initialize()
    writer.attach(products)


def with_an_overriding_writer(products, folder):
    writer = Overriding(output_dir=str(folder / "own"), rgb=True)
    writer.attach(products)


def with_an_annotator(products, folder):
    rep.annotators.get("rgb").attach(products[0])


def with_an_augmentation(products, folder):
    writer = current().writers[0]
    writer.augment_annotator("rgb", lambda data_in: data_in[::-1].copy())


def with_a_point_cloud(products, folder):
    basic_writer(folder / "cloud", products, pointcloud=True)


def with_a_backend_that_runs_jobs_at_once(products, folder):
    class AtOnce(DiskBackend):
        def schedule(self, fn, *args, **kwargs):
            fn(*args, **kwargs, backend_instance=self)

    basic_writer(folder, products, backend=AtOnce(output_dir=str(folder / "once")), output_dir=None)


def with_motion_blur(products, folder):
    get_settings().set("/rtx/rendermode", "PathTracing")
    get_settings().set("/rtx/pathtracing/totalSpp", 2)
    get_settings().set("/omni/replicator/captureMotionBlur", True)


@pytest.mark.parametrize(
    "reader",
    [
        with_a_looking_writer, with_an_overriding_writer, with_an_annotator, with_an_augmentation, with_a_point_cloud,
        with_a_backend_that_runs_jobs_at_once, with_motion_blur,
    ],
)  # fmt: skip
def test_pictures_that_somebody_looks_at_are_never_later(tmp_path, stage, started, reader):
    products = build_scene()[:1]
    basic_writer(tmp_path / "files", products)
    reader(products, tmp_path)
    for _ in range(3):
        rep.orchestrator.step()
    rep.orchestrator.wait_until_complete()
    assert started == []


def test_settings_of_the_next_frame_do_not_change_the_picture(tmp_path, stage, gate):
    """Samples, bounces and tone are those of the frame, whatever a script sets after `step`."""
    pictures = {}
    for later in (False, True):
        session.restart()
        new_stage()
        gate.set()
        get_settings().set(later_pictures.SETTING, later)
        folder = tmp_path / str(later)
        basic_writer(folder, build_scene()[:1])
        rep.orchestrator.step()
        gate.clear()
        rep.orchestrator.step()
        get_settings().set("/rtx/post/tonemap/filmIso", 400.0)
        get_settings().set("/rtx/pathtracing/maxSpecularAndTransmissionBounces", 0)
        rep.set_global_seed(77)
        gate.set()
        rep.orchestrator.wait_until_complete()
        pictures[later] = content(folder)["rgb_0001.png"]
    assert pictures[False] == pictures[True]


def test_a_picture_that_fails_names_its_frame_and_file_and_leaves_none(tmp_path, stage, monkeypatch):
    basic_writer(tmp_path, build_scene()[:1])
    rep.orchestrator.step()

    def fails(renderer, films, tone=None, **options):
        raise MemoryError("out of memory")

    monkeypatch.setattr(WarpRenderer, "develop_all", fails)
    rep.orchestrator.step()
    with pytest.raises(WriterError, match=r"frame 1: .*rgb_0001.png.* could not be written.*out of memory"):
        rep.orchestrator.wait_until_complete()
    assert not (tmp_path / "rgb_0001.png").exists()
    monkeypatch.undo()
    parallel.Later(lambda: None).wait()  # the thread is still there


def test_an_interrupted_run_leaves_whole_files(tmp_path, stage, started):
    basic_writer(tmp_path, build_scene()[:1])
    frames = 0

    def interrupt() -> None:
        nonlocal frames
        frames += 1
        if frames == 3:
            raise KeyboardInterrupt

    rep.orchestrator.get_orchestrator().on_captured(interrupt)
    with pytest.raises(KeyboardInterrupt):
        rep.orchestrator.run(num_frames=10)
    assert started == [1, 2]
    rep.orchestrator.wait_until_complete()
    for name in ("rgb_0001.png", "rgb_0002.png"):
        assert np.asarray(Image.open(tmp_path / name)).shape == (*SIZE[::-1], 4)


def test_another_stage_does_not_change_the_picture(tmp_path, stage, gate):
    basic_writer(tmp_path, build_scene()[:1])
    gate.set()
    rep.orchestrator.step()
    gate.clear()
    rep.orchestrator.step(delta_time=0.0)  # a timeline that plays would be stopped, which waits for the files
    new_stage()
    gate.set()
    rep.orchestrator.wait_until_complete()
    assert np.asarray(Image.open(tmp_path / "rgb_0001.png"))[..., :3].max() > 2


# Datasets of writers that store pictures without looking at them; a point cloud has the colors of its points.
STORED = [
    name
    for name, (kind, options, _) in datasets.DATASETS.items()
    if type(rep.writers.get(kind)).only_stores_pictures and "pointcloud" not in options
]


def test_writers_that_store_pictures_never_look_at_pixels(tmp_path, stage, started, monkeypatch):
    """Pixels are wrong until `step` has returned, and still every file has the bytes that it has otherwise."""

    def switched_off(frame: int) -> None:
        get_settings().set(later_pictures.SETTING, False)

    at_once = content(datasets.make(tmp_path / "x", STORED, edit=switched_off))
    assert not started
    returned = threading.Semaphore(0)
    real = later_pictures.LaterPictures._trace

    def trace(pictures) -> None:
        for images in pictures.images.values():
            images[later_pictures.COLOR][...] = 123
        assert returned.acquire(timeout=60)
        real(pictures)

    def let_trace_once_captured(frame: int) -> None:
        if frame == 0:
            rep.orchestrator.get_orchestrator().on_captured(lambda: started and returned.release())

    monkeypatch.setattr(later_pictures.LaterPictures, "_trace", trace)
    later = content(datasets.make(tmp_path / "y", STORED, edit=let_trace_once_captured))
    assert started == [1, 2, 3]
    assert sorted(later) == sorted(at_once)
    assert [name for name in at_once if later[name] != at_once[name]] == []
    assert {name.split("/")[0] for name in later} >= {
        "basic_ids",
        "coco",
        "voc",
        "cvat",
        "kitti",
        "pose",
        "yolo",
        "bop",
    }
