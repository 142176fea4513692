"""Files that are no files, that are damaged, or that would take all memory, are named in one line and not read."""

import json
import os
import struct
import tracemalloc
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from pxr import Usd, UsdGeom, UsdUtils

import usdsdg as rep
from usdsdg.calibration.files import read_calibration
from usdsdg.datasets.folder import Folder
from usdsdg.errors import ArgumentError, AssetUnreadable, ConfigError, UsdsdgError
from usdsdg.inspect.report import inspect
from usdsdg.meshes.readers import read as read_mesh
from usdsdg.replicator_yaml import run_file
from usdsdg.scenarios.config_file import read_config
from usdsdg.scenarios.jobs import load_job
from usdsdg.scenarios.object_based.config import ObjectBasedConfig
from usdsdg.session.stage_context import open_stage
from usdsdg.stage.assets import check_file, missing_dependencies
from usdsdg.stage.semantics.semantic_classes import read_semantic_classes
from usdsdg_render.images import image_files

CONFIGS = Path(__file__).parents[2] / "configs"


@pytest.mark.parametrize("path", ["/dev/zero", "/dev/random", "pipe"])
def test_devices_and_pipes_are_no_textures(tmp_path, path):
    if path == "pipe":
        path = str(tmp_path / "pipe.png")
        os.mkfifo(path)
    with pytest.raises(AssetUnreadable, match="is a device, pipe or socket"):
        image_files.read(path)


def test_a_pipe_is_no_stage_and_no_part_of_one(tmp_path):
    os.mkfifo(tmp_path / "pipe.usda")
    with pytest.raises(AssetUnreadable, match="is a device, pipe or socket"):
        open_stage(tmp_path / "pipe.usda")
    for said in ('def Xform "A" (references = @./pipe.usda@) {}', 'def Xform "A" (payload = @./pipe.usda@) {}'):
        (tmp_path / "stage.usda").write_text(f"#usda 1.0\n{said}\n")
        with pytest.raises(AssetUnreadable, match=r"pipe.usda is a device, pipe or socket"):
            open_stage(tmp_path / "stage.usda")
        (tmp_path / "stage.usda").unlink()
        with pytest.raises(AssetUnreadable):
            rep.create.from_usd(str(tmp_path / "pipe.usda"))


def test_a_pipe_in_a_dataset_is_a_fault(tmp_path):
    os.mkfifo(tmp_path / "rgb_0000.png")
    folder = Folder(tmp_path)
    assert folder.image("rgb_0000.png", "0") is None
    assert [fault.what for fault in folder.faults] == ["is no file"]


def bomb(width, height):
    """A PNG of one color, of a thousandth of its pixels in bytes."""
    raw = zlib.compress(bytes((width + 1) * height), 9)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", raw) + chunk(b"IEND", b"")


def test_a_decompression_bomb_is_refused(tmp_path):
    (tmp_path / "bomb.png").write_bytes(bomb(12_000, 12_000))
    with pytest.raises(AssetUnreadable, match=r"bomb.png: its \d+ bytes would become an image of 12000 x 12000"):
        image_files.read(str(tmp_path / "bomb.png"))
    (tmp_path / "flat.png").write_bytes(bomb(2_000, 2_000))
    assert image_files.read(str(tmp_path / "flat.png")).texels.shape == (2_000, 2_000, 4)


def test_a_radiance_image_of_a_few_bytes_and_many_pixels_is_refused(tmp_path):
    head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n"
    runs = bytes([9, 9, 9, 128]) + b"".join(bytes([1, 1, 1, 255]) for _ in range(4))  # old coding: 2^32 times a pixel
    (tmp_path / "sky.hdr").write_bytes(head % (16_000, 15_000) + runs)
    with pytest.raises(AssetUnreadable, match=r"sky.hdr: its \d+ bytes would become an image of 15000 x 16000"):
        image_files.read(str(tmp_path / "sky.hdr"))
    (tmp_path / "small.hdr").write_bytes(head % (40, 30) + runs)
    assert image_files.read(str(tmp_path / "small.hdr")).texels.shape == (40, 30, 4)
    (tmp_path / "digits.hdr").write_bytes(b"#?RADIANCE\n\n-Y " + b"9" * 5000 + b" +X 4\n" + runs)
    with pytest.raises(AssetUnreadable, match="the resolution line"):
        image_files.read(str(tmp_path / "digits.hdr"))


@pytest.mark.parametrize("size", [0, 95, 97, 1 << 28])
def test_a_png_of_16_bits_holds_the_data_that_its_header_tells_of(size, tmp_path):
    raw = zlib.compress(bytes(size), 9)  # of 4 x 4 pixels: 4 rows of a filter and 12 samples, 100 bytes
    head = struct.pack(">IIBBBBB", 4, 4, 16, 2, 0, 0, 0)
    chunks = ((b"IHDR", head), (b"IDAT", raw), (b"IEND", b""))
    data = b"".join(struct.pack(">I", len(d)) + k + d + struct.pack(">I", zlib.crc32(k + d)) for k, d in chunks)
    (tmp_path / "deep.png").write_bytes(b"\x89PNG\r\n\x1a\n" + data)
    tracemalloc.start()
    with pytest.raises(AssetUnreadable, match=r"deep.png: the image data is truncated, or of another size"):
        image_files.read(str(tmp_path / "deep.png"))
    assert tracemalloc.get_traced_memory()[1] < 8 << 20
    tracemalloc.stop()


def test_images_of_kinds_that_no_decoder_reads_are_named(tmp_path):
    image = Image.fromarray(np.full((8, 8, 3), 90, np.uint8))
    flags = 80  # of the pixel format in the header of a DDS file
    image.save(tmp_path / "good.dds")
    data = bytearray((tmp_path / "good.dds").read_bytes())
    data[flags : flags + 4] = struct.pack("<I", 1 << 19)  # of bump maps
    (tmp_path / "bump.dds").write_bytes(data)
    with pytest.raises(AssetUnreadable, match=r"bump.dds: Unknown pixel format"):
        image_files.read(str(tmp_path / "bump.dds"))


TRIANGLE = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}]} | {
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
}


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no pipes in folders")
def test_a_pipe_beside_a_mesh_is_not_read(tmp_path):
    os.mkfifo(tmp_path / "points.bin")
    gltf = TRIANGLE | {"buffers": [{"uri": "points.bin", "byteLength": 36}]}
    (tmp_path / "mesh.gltf").write_text(json.dumps(gltf))
    with pytest.raises(AssetUnreadable, match=r"points.bin is a device, pipe or socket"):
        read_mesh(tmp_path / "mesh.gltf")


def test_a_mesh_goes_without_a_picture_of_a_kind_that_no_decoder_reads(tmp_path):
    Image.fromarray(np.full((8, 8, 3), 90, np.uint8)).save(tmp_path / "good.dds")
    data = bytearray((tmp_path / "good.dds").read_bytes())
    data[80:84] = struct.pack("<I", 1 << 19)
    (tmp_path / "bump.dds").write_bytes(data)
    (tmp_path / "mesh.mtl").write_text("newmtl paint\nKd 1 1 1\nmap_Kd bump.dds\n")
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
    (tmp_path / "mesh.obj").write_text(f"mtllib mesh.mtl\n{corners}usemtl paint\nf 1/1 2/2 3/3\n")
    mesh = read_mesh(tmp_path / "mesh.obj")
    assert [len(part.triangles) for part in mesh.parts] == [1]
    # One for each picture that is left out.
    assert [note.partition(" cannot be read")[0] for note in mesh.notes] == ["the picture bump.dds"]


@pytest.fixture
def package(tmp_path):
    """A package with a stage and a texture."""
    Image.fromarray(np.full((8, 8, 3), 90, np.uint8)).save(tmp_path / "color.png")
    stage = Usd.Stage.CreateNew(str(tmp_path / "in.usda"))
    mesh = UsdGeom.Mesh.Define(stage, "/Mesh")
    stage.SetDefaultPrim(mesh.GetPrim())
    mesh.GetPrim().CreateAttribute("texture", UsdGeom.Tokens and __import__("pxr").Sdf.ValueTypeNames.Asset).Set(
        "color.png"
    )
    stage.Save()
    UsdUtils.CreateNewUsdzPackage(str(tmp_path / "in.usda"), str(tmp_path / "whole.usdz"))
    return tmp_path / "whole.usdz"


@pytest.mark.parametrize("found", [b"IDAT", b"Mesh"])
def test_a_package_with_a_wrong_checksum_is_an_error(package, tmp_path, found):
    data = bytearray(package.read_bytes())
    data[data.index(found) + len(found)] ^= 4
    (tmp_path / "flipped.usdz").write_bytes(data)
    open_stage(package)
    with pytest.raises(AssetUnreadable, match=r"flipped.usdz is damaged: the checksum"):
        open_stage(tmp_path / "flipped.usdz")
    (tmp_path / "outer.usda").write_text('#usda 1.0\ndef "A" (references = @./flipped.usdz@) {}\n')
    with pytest.raises(AssetUnreadable, match=r"flipped.usdz is damaged: the checksum"):
        open_stage(tmp_path / "outer.usda")


def test_bytes_that_are_no_text_are_told_in_one_line(tmp_path):
    (tmp_path / "bad.usda").write_bytes(b'#usda 1.0\ndef Cube "C" { string x = "\xff\xfe" }\n')
    with pytest.raises(AssetUnreadable, match="bytes that are no UTF-8 text"):
        open_stage(tmp_path / "bad.usda")


@pytest.mark.parametrize("arc", ["references", "payload", "subLayers"])
def test_bytes_that_are_no_text_in_what_a_stage_refers_to_are_told_with_their_line(arc, tmp_path):
    part, stage = tmp_path / "latin.usda", tmp_path / "stage.usda"
    part.write_bytes('#usda 1.0\n(\n    defaultPrim = "A"\n)\ndef Cube "A" (doc = "café")\n{\n}\n'.encode("latin-1"))
    layers = f"(\n    subLayers = [@./{part.name}@]\n)\n" if arc == "subLayers" else ""
    refers = "" if layers else f"({arc} = @./{part.name}@)"
    stage.write_text(f'#usda 1.0\n{layers}def Xform "B" {refers}\n{{\n}}\ndef Cube "C"\n{{\n}}\n')
    opened = open_stage(str(stage))
    assert opened.GetPrimAtPath("/C")
    missing = missing_dependencies(opened)
    assert [each.asset_path for each in missing] == [str(part)]
    assert f"{part}:5:" in missing[0].why
    assert "\n" not in missing[0].why


def test_numbers_of_prims_have_bounds_that_name_memory_and_time(tmp_path):
    with pytest.raises(ArgumentError, match=r"at most 1000000 .* 8 GB of memory"):
        rep.create.cube(count=10**12)
    (tmp_path / "job.yaml").write_text("shape_distractors_num: 1000000000000\n")
    with pytest.raises(ConfigError, match=r"at most 1000000 .* 8 GB of memory"):
        read_config(tmp_path / "job.yaml", (), ObjectBasedConfig)


@pytest.mark.parametrize("key", ["drops", "frames_per_drop", "cameras.count"])
def test_numbers_of_bin_picking_have_bounds(key):
    with pytest.raises(ConfigError, match=rf"{key}: .*1000000"):
        load_job(CONFIGS / "bin_picking.yaml", [f"{key}=1000000000000"])


@pytest.mark.parametrize("job", ["object_based", "bin_picking", "detection"])
def test_seeds_are_no_numbers_of_things(job):
    assert load_job(CONFIGS / f"{job}.yaml", [f"seed={2**40}"])[1].seed == 2**40
    with pytest.raises(ConfigError, match="seed"):
        load_job(CONFIGS / f"{job}.yaml", [f"seed={10**40}"])


YAML = {
    "aliases": "\n".join(["a0: &a0 [x, x, x, x, x, x, x, x, x]"] + [
        f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]" for n in range(1, 10)
    ]),
    "nesting": "a: " + "[" * 5000 + "]" * 5000,
    "keys": "\n".join(f"key{n}: 1" for n in range(20_000)),
    "digits": "num_frames: " + "9" * 6000,
    "objects": "a: !!python/object/apply:os.system ['id']",
    "size": "a: " + "x" * (1 << 21),
}  # fmt: skip


def test_a_character_that_yaml_does_not_have_is_told_with_its_line(tmp_path):
    (tmp_path / "graph.yaml").write_text("a:\n  create.cube:\n    count: \x7f1\n")
    with pytest.raises(ConfigError, match=r"graph.yaml, line 3: the character #x007f is not allowed"):
        run_file(tmp_path / "graph.yaml")


READERS = {
    "configuration": lambda file: read_config(file, (), ObjectBasedConfig),
    "graph": run_file,
    "calibration": read_calibration,
    "classes": read_semantic_classes,
}


@pytest.mark.parametrize("name", READERS)
def test_settings_are_read_of_files_only_and_of_small_ones(tmp_path, name):
    os.mkfifo(tmp_path / "pipe.yaml")
    with pytest.raises(UsdsdgError, match=r"pipe.yaml is a device, pipe or socket"):
        READERS[name](tmp_path / "pipe.yaml")
    with open(tmp_path / "large.yaml", "wb") as file:
        file.truncate(1 << 40)
    with pytest.raises(UsdsdgError, match=r"large.yaml .*has more than \d+ MB"):
        READERS[name](tmp_path / "large.yaml")
    (tmp_path / "deep.yaml").write_text("[" * 1500)
    with pytest.raises(UsdsdgError, match=r"deep.yaml"):
        READERS[name](tmp_path / "deep.yaml")


@pytest.mark.parametrize("name", YAML)
def test_yaml_is_limited(tmp_path, name):
    (tmp_path / "job.yaml").write_text(YAML[name])
    with pytest.raises(ConfigError) as raised:
        read_config(tmp_path / "job.yaml", (), ObjectBasedConfig)
    assert len(str(raised.value)) < 1000
    assert "job.yaml" in str(raised.value)


@pytest.mark.parametrize(
    "call", ["writers.backends.os.system: {command: id}", "functional.write_json: {path: /a, data: 1}"]
)
def test_yaml_calls_no_function_beyond_its_table(tmp_path, call):
    (tmp_path / "graph.yaml").write_text(f"x: {{{call}}}\n")
    with pytest.raises(ConfigError, match=r"may call|cannot call"):
        run_file(tmp_path / "graph.yaml")


def test_the_page_of_inspect_escapes_what_a_dataset_is_called(tmp_path):
    folder = tmp_path / "{{images}} {{data}} <script>alert(1)"
    folder.mkdir()
    Image.fromarray(np.zeros((4, 4, 3), np.uint8)).save(folder / "rgb_0000.png")
    page = inspect(folder, tmp_path / "page.html").read_text()
    assert "<script>alert(1)" not in page
    assert page.count("{{images}} {{data}}") >= 1
    assert page.rstrip().endswith("</html>")


def test_prims_that_are_too_deep_in_each_other_are_refused(tmp_path):
    """USD's own reader takes minutes for 40,000, and 100,000 end the process."""
    for count in (3000, 100_000):
        text = "#usda 1.0\n" + 'def Xform "a" {\n' * count + "}\n" * count
        (tmp_path / f"{count}.usda").write_text(text)
    check_file(str(tmp_path / "3000.usda"))
    with pytest.raises(AssetUnreadable, match=r"100000.usda has prims 100000 deep in each other"):
        open_stage(tmp_path / "100000.usda")


def test_a_crate_of_which_the_table_of_contents_is_damaged_is_refused(tmp_path):
    """USD itself would read as many sections as the count says, for minutes."""
    good = tmp_path / "good.usdc"
    stage = Usd.Stage.CreateNew(str(good))
    UsdGeom.Sphere.Define(stage, "/Ball")
    stage.Save()
    check_file(str(good))
    data = good.read_bytes()
    (place,) = struct.unpack_from("<q", data, 16)
    for name, damaged in {
        "count.usdc": data[:place] + struct.pack("<Q", 600_000_000) + data[place + 8 :],
        "place.usd": data[:16] + struct.pack("<q", len(data)) + data[24:],
        "short.usdc": data[: place + 40],
    }.items():
        (tmp_path / name).write_bytes(damaged)
        with pytest.raises(AssetUnreadable, match=rf"{name} cannot be opened as USD: its table of contents"):
            check_file(str(tmp_path / name))


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="Windows has other rights")
@pytest.mark.parametrize("name", ["scene.usda", "scene.usd", "scene.usdc", "scene.usdz"])
def test_a_file_of_usd_that_this_user_may_not_read_is_named(name, tmp_path, monkeypatch):
    file = tmp_path / name
    file.write_bytes(b"PXR-USDC" if name.endswith("c") else b"#usda 1.0\n")
    file.chmod(0)
    tmp_path.chmod(0o755)
    monkeypatch.chdir(tmp_path)  # the folders above may be closed to others, too
    root = os.geteuid() == 0
    try:
        if root:
            os.seteuid(65534)  # the limits of files do not hold for root
        with pytest.raises(AssetUnreadable, match=f"{name} .*Permission denied"):
            check_file(name)
    finally:
        if root:
            os.seteuid(0)
