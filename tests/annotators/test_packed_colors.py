"""Colorized segmentation as scripts for Isaac Sim 4 and 6 expect it."""

import filecmp
from pathlib import Path

import numpy as np
import pytest

from tests.annotators.ray_caster import known, make_frame
from tests.annotators.scenes import street
from usdsdg import annotators, writers
from usdsdg.errors import BadValue
from usdsdg.session import session
from usdsdg.session.settings.replicator_version import KEY, note_old_import, replicator_version
from usdsdg.session.settings.store import get_settings

PRODUCT = "/Render/HydraTextures/rp1"
SEGMENTATION = [
    "semantic_segmentation", "instance_segmentation", "instance_segmentation_fast", "instance_id_segmentation",
    "instance_id_segmentation_fast",
]  # fmt: skip


@pytest.fixture(scope="module")
def frame():
    return make_frame(street(), (64, 48), filters=[None, "class:*"])


@pytest.fixture(autouse=True)
def own_session():
    session.restart()
    yield
    session.restart()


def colorized(name, frame):
    return annotators.get(name, {"colorize": True}).compute(frame)


@pytest.mark.parametrize("name", SEGMENTATION)
def test_the_same_colors_in_both_layouts(name, frame):
    new = colorized(name, frame)
    assert (new.data.dtype, new.data.shape) == (np.uint8, (48, 64, 4))
    get_settings().set(KEY, 4)
    old = colorized(name, frame)
    assert (old.data.dtype, old.data.shape) == (np.uint32, (48, 64))
    # How scripts of that time read it.
    np.testing.assert_array_equal(np.frombuffer(old.data, np.uint8).reshape(*old.data.shape, -1), new.data)
    np.testing.assert_array_equal(old.data.view(np.uint8).reshape(48, 64, -1), new.data)
    assert old.info == new.info
    ids = annotators.get(name).compute(frame)
    assert (ids.data.dtype, ids.data.shape) == (np.uint32, (48, 64))


def test_the_version_is_what_the_setting_or_the_imports_say():
    assert replicator_version() == 6
    note_old_import()
    assert replicator_version() == 4
    for version in (6, 4):
        get_settings().set(KEY, version)
        assert replicator_version() == version
    get_settings().set(KEY, 5)
    with pytest.raises(BadValue, match="is 5; expected 4, 6, or 0"):
        replicator_version()


def test_an_augmentation_gets_the_layout_of_the_version(frame):
    get_settings().set(KEY, 4)
    shapes = []
    annotators.get("semantic_segmentation", {"colorize": True}).augment(
        lambda image: shapes.append(image.shape) or image
    ).compute(frame)
    assert shapes == [(48, 64)]


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("BasicWriter", dict.fromkeys(("semantic_segmentation", "instance_segmentation"), True)),
        ("BasicWriter", {"instance_id_segmentation": True, "colorize_instance_id_segmentation": False}),
        ("CosmosWriter", {}),
        ("CosmosWriter", {"segmentation_mapping": {"Apple": [255, 0, 0, 255]}}),
    ],
)
def test_our_writers_write_the_same_files_for_both(name, options, frame, tmp_path):
    written = []
    for version in (4, 6):
        get_settings().set(KEY, version)
        writer = writers.get(name, init_params={"output_dir": str(tmp_path / str(version)), **options})
        writer.attach(known(PRODUCT))
        writer.receive(annotators.build_payload(writer, {PRODUCT: frame}))
        writer.detach()
        writer.backend.wait_until_done()
        written.append(Path(writer.backend.output_dir))
    old, new = written
    names = sorted(str(path.relative_to(new)) for path in new.rglob("*") if path.is_file())
    assert names
    assert filecmp.cmpfiles(old, new, names, shallow=False)[0] == names
