"""Image files to texels: formats, color spaces, baking, sharing, damage."""

import io
import struct
import zipfile
import zlib

import numpy as np
import pytest
from PIL import Image

from usdsdg import errors
from usdsdg.stage.colors import linear_to_srgb, srgb_to_linear
from usdsdg_render.images import image_files
from usdsdg_render.images.textures import TexturePool, TextureUse
from usdsdg_render.scene.scene import WRAP_CLAMP, UvTransform

RED = (200, 100, 50)


def save(path, array, **options):
    Image.fromarray(array).save(path, **options)
    return str(path)


def texture(path, **options):
    table, places = TexturePool().load([TextureUse(str(path), **options)])
    return table[next(iter(places.values()))]


def seen(loaded):
    """(N, 4) linear values that a texture shows, texel by texel."""
    most = {"uint8": 255.0, "uint16": 65535.0, "float16": 1.0}[loaded.texels.dtype.name]
    values = loaded.texels.reshape(-1, 4) / np.float64(most)
    if loaded.srgb:
        values[:, :3] = srgb_to_linear(values[:, :3])
    return np.maximum(values * loaded.scale + loaded.bias, 0.0)


def flat(path, **options):
    """The one color of a flat texture, linear, and whether it is stored sRGB-coded."""
    loaded = texture(path, **options)
    values = seen(loaded)
    np.testing.assert_array_equal(values, np.broadcast_to(values[0], values.shape))
    return values[0], loaded.srgb


def test_srgb_curve_is_the_standard_one_and_its_inverse():
    np.testing.assert_allclose(srgb_to_linear(np.array([0, 0.04045, 0.5, 1.0])), [0, 0.0031308, 0.214041, 1], atol=1e-6)
    values = np.linspace(0, 1, 101)
    np.testing.assert_allclose(srgb_to_linear(linear_to_srgb(values)), values, atol=1e-6)


def test_rows_start_at_the_top_and_columns_at_the_left(tmp_path):
    array = np.arange(2 * 3 * 3, dtype=np.uint8).reshape(2, 3, 3)
    loaded = texture(save(tmp_path / "a.png", array))
    np.testing.assert_array_equal(loaded.texels[..., :3], array)
    assert (loaded.texels[..., 3] == 255).all()
    assert loaded.texels.flags.c_contiguous


@pytest.mark.parametrize(
    ("mode", "value", "rgba", "is_srgb"),
    [
        ("RGB", RED, (*RED, 255), True),
        ("RGBA", (*RED, 128), (*RED, 128), True),
        ("L", 120, (120, 120, 120, 255), False),
        ("LA", (120, 60), (120, 120, 120, 60), False),
        ("1", 1, (255, 255, 255, 255), False),
    ],
)
def test_eight_bit_modes(mode, value, rgba, is_srgb, tmp_path):
    Image.new(mode, (4, 3), value).save(tmp_path / "a.png")
    loaded = texture(tmp_path / "a.png")
    assert loaded.texels.shape == (3, 4, 4)
    assert (loaded.texels == rgba).all()
    assert loaded.srgb is is_srgb, "auto: 8 bits with three or four channels"


def test_palette_images_are_colors(tmp_path):
    Image.new("RGB", (4, 4), RED).quantize(4).save(tmp_path / "p.png")
    loaded = texture(tmp_path / "p.png")
    assert (loaded.texels == (*RED, 255)).all()
    assert loaded.srgb


def test_palette_transparency_becomes_alpha(tmp_path):
    Image.new("P", (4, 4), 0).save(tmp_path / "p.png", transparency=0)
    assert (texture(tmp_path / "p.png").texels[..., 3] == 0).all()


def test_cmyk_jpeg_is_turned_into_rgb(tmp_path):
    Image.new("RGB", (16, 16), RED).convert("CMYK").save(tmp_path / "c.jpg", quality=95)
    np.testing.assert_allclose(texture(tmp_path / "c.jpg").texels[8, 8, :3], RED, atol=6)


@pytest.mark.parametrize("space", ["auto", "raw", "sRGB"])
def test_sixteen_bit_gray(space, tmp_path):
    stored = 0.25
    path = save(tmp_path / "g.png", np.full((4, 4), round(stored * 65535), np.uint16))
    values, _ = flat(path, color_space=space)
    expected = srgb_to_linear(np.array(stored)) if space == "sRGB" else stored
    np.testing.assert_allclose(values[:3], expected, rtol=0.02)
    data, coded = flat(path, color_space=space, color=False)
    np.testing.assert_allclose(data[:3], expected, atol=1e-5)
    assert not coded, "data keeps its sixteen bits"


def deep_png(values: np.ndarray, filters) -> bytes:
    """A PNG of (H, W, n) uint16 values, whose rows are filtered as told: the specification, byte by byte."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    height, width, channels = values.shape
    size = 2 * channels
    rows = values.astype(">u2").view(np.uint8).reshape(height, width * size).astype(int)
    stored = b""
    for y, kind in zip(range(height), filters):
        line = bytearray([kind])
        for k in range(width * size):
            a = rows[y, k - size] if k >= size else 0
            b = rows[y - 1, k] if y else 0
            c = rows[y - 1, k - size] if y and k >= size else 0
            p = a + b - c
            paeth = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            line.append((rows[y, k] - (0, a, b, (a + b) // 2, paeth)[kind]) % 256)
        stored += bytes(line)
    kinds = {2: 4, 3: 2, 4: 6}
    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 16, kinds[channels], 0, 0, 0))
    body = zlib.compress(stored)
    cut = len(body) // 2
    parts = chunk(b"IDAT", body[:cut]) + chunk(b"IDAT", body[cut:])
    return b"\x89PNG\r\n\x1a\n" + head + parts + chunk(b"IEND", b"")


@pytest.mark.parametrize("channels", [2, 3, 4])
@pytest.mark.parametrize("filters", [(0,) * 6, (1,) * 6, (2,) * 6, (3,) * 6, (4,) * 6, (4, 1, 3, 0, 2, 4)])
def test_sixteen_bit_pngs_keep_all_bits(filters, channels, tmp_path):
    values = np.random.default_rng(7).integers(0, 65536, (6, 9, channels)).astype(np.uint16)
    (tmp_path / "x.png").write_bytes(deep_png(values, filters))
    with Image.open(tmp_path / "x.png") as image:  # other readers accept it too
        assert np.asarray(image.convert("RGBA")).shape == (6, 9, 4)
    texels = texture(tmp_path / "x.png", color=False, color_space="raw").texels
    assert texels.dtype == np.uint16
    expected = values[..., [0, 0, 0, 1]] if channels == 2 else values
    np.testing.assert_array_equal(texels[..., : expected.shape[2]], expected)
    np.testing.assert_array_equal(image_files.read_rgb(str(tmp_path / "x.png")), texels[..., :3])
    if channels == 3:
        assert (texels[..., 3] == 65535).all()


def sixteen_bit_tiff(values):
    """An uncompressed TIFF of (H, W, 3) uint16."""
    height, width, channels = values.shape
    data = values.astype("<u2").tobytes()
    entries = [(256, width), (257, height), (258, 0), (259, 1), (262, 2), (273, 0), (277, channels), (278, height)]
    entries += [(279, len(data)), (284, 1)]
    depths = 8 + 2 + 12 * len(entries) + 4
    places = {258: (3, 3, depths), 273: (4, 1, depths + 2 * channels), 279: (4, 1, len(data))}
    table = [struct.pack("<HHII", tag, *places.get(tag, (3, 1, value))) for tag, value in entries]
    head = b"II*\0" + struct.pack("<IH", 8, len(entries))
    return head + b"".join(table) + struct.pack("<I3H", 0, 16, 16, 16) + data


def interlaced_png(values):
    """An interlaced PNG of (1, 1, 3) uint16: of one pixel, all seven passes but the first are empty."""
    png = deep_png(values, (0,))
    header = png[12:28] + b"\x01"
    return png[:12] + header + struct.pack(">I", zlib.crc32(header)) + png[33:]


@pytest.mark.parametrize(("name", "written"), [("x.tif", sixteen_bit_tiff), ("x.png", interlaced_png)])
def test_colors_of_16_bits_are_linear_also_where_their_low_bits_are_lost(name, written, tmp_path):
    """UsdUVTexture: of sourceColorSpace auto, 8-bit files alone are sRGB."""
    values = np.array([[[30000, 20000, 10000]]], np.uint16)
    (tmp_path / name).write_bytes(written(values))
    for space, expected in (("auto", values / 65535), ("sRGB", srgb_to_linear(values / 65535))):
        shown = seen(texture(tmp_path / name, color_space=space))
        np.testing.assert_allclose(shown[0, :3], expected[0, 0], atol=0.004)


def test_cut_off_sixteen_bit_pngs_are_named(tmp_path):
    whole = deep_png(np.zeros((4, 4, 3), np.uint16), (0,) * 4)
    (tmp_path / "x.png").write_bytes(whole[:50])
    with pytest.raises(errors.AssetUnreadable, match=r"x\.png"):
        image_files.read(str(tmp_path / "x.png"))


@pytest.mark.parametrize("mode", ["1", "L", "LA", "P", "RGB", "RGBA", "I;16", "F"])
def test_images_without_alpha_have_the_same_colors(mode, tmp_path):
    file = str(tmp_path / "x.tiff" if mode == "F" else tmp_path / "x.png")
    shape = (5, 7)
    values = np.random.default_rng(0).integers(0, 256, shape, np.uint8)
    if mode == "I;16":
        image = Image.fromarray(values.astype(np.uint16) * 257)
    else:
        image = Image.fromarray(values).convert(mode)
    image.save(file)
    rgb = image_files.read_rgb(file)
    assert rgb.shape == (*shape, 3)
    np.testing.assert_array_equal(rgb, image_files.read(file).texels[..., :3])


def test_float_images_are_linear_whatever_their_file(tmp_path):
    Image.fromarray(np.full((4, 4), 0.5, np.float32)).save(tmp_path / "f.tiff")
    values, coded = flat(tmp_path / "f.tiff")
    np.testing.assert_allclose(values[:3], 0.5, atol=0.005)
    assert coded, "a linear color in eight bits is stored sRGB-coded, so that darks do not band"
    assert flat(tmp_path / "f.tiff", color=False)[1] is False


def test_radiance_images_serve_as_textures(tmp_path):
    (tmp_path / "a.hdr").write_bytes(b"#?RADIANCE\n\n-Y 1 +X 1\n" + bytes([64, 32, 255, 129]))
    values, _ = flat(tmp_path / "a.hdr")
    np.testing.assert_allclose(values[:3], [0.5, 0.25, 255 / 128], rtol=1e-3)


@pytest.mark.parametrize("space", ["raw", "sRGB"])
def test_scale_and_bias_act_on_linear_values(space, tmp_path):
    path = save(tmp_path / "a.png", np.full((2, 2, 3), 100, np.uint8))
    stored = 100 / 255
    linear = srgb_to_linear(np.array(stored)) if space == "sRGB" else stored
    values, _ = flat(path, color_space=space, scale=(2.0, 0.5, 1.0, 1.0), bias=(0.1, 0.0, -2.0, 0.0))
    np.testing.assert_allclose(values[:3], [2 * linear + 0.1, linear / 2, 0.0], atol=0.005)


def test_desaturation_keeps_luminance(tmp_path):
    path = save(tmp_path / "a.png", np.full((2, 2, 3), RED, np.uint8))
    linear = srgb_to_linear(np.array(RED) / 255)
    luminance = linear @ [0.2126, 0.7152, 0.0722]
    gray, _ = flat(path, desaturation=1.0)
    np.testing.assert_allclose(gray[:3], luminance, atol=0.005)
    half, _ = flat(path, desaturation=0.5)
    np.testing.assert_allclose(half[:3], (linear + luminance) / 2, atol=0.005)


def test_equal_uses_share_and_the_table_keeps_its_order(tmp_path):
    a = save(tmp_path / "a.png", np.zeros((2, 2, 3), np.uint8))
    b = save(tmp_path / "b.png", np.ones((2, 2, 3), np.uint8))
    pool = TexturePool()
    data, color = TextureUse(a, "raw", False), TextureUse(a, "raw", True)
    table, places = pool.load([data, color, TextureUse(a, "raw", wrap_s=WRAP_CLAMP)])
    assert places[data] == places[color], "nothing to bake: the same texels"
    assert len(table) == 2
    assert table[0].texels is table[1].texels
    again, more = pool.load([TextureUse(b), data])
    assert again[0] is table[0]
    assert more[data] == places[data]
    assert len(again) == 2, "another look at the same texels is replaced"
    last, _ = pool.load([TextureUse(b)])
    assert last[0] is table[0], "idle textures stay while they are small"


def test_a_rewritten_file_is_read_again(tmp_path):
    path = save(tmp_path / "a.png", np.zeros((2, 2, 3), np.uint8))
    pool = TexturePool()
    use = TextureUse(path)
    pool.load([use])
    save(tmp_path / "a.png", np.full((9, 9, 3), 255, np.uint8))
    table, places = pool.load([use])
    assert table[places[use]].texels.shape == (9, 9, 4)


@pytest.mark.parametrize("name", ["missing.png", "cut.png", "text.png", "empty.png"])
def test_unreadable_files_are_named_and_absent(name, tmp_path):
    whole = io.BytesIO()
    Image.effect_noise((64, 64), 50).save(whole, "PNG")
    (tmp_path / "cut.png").write_bytes(whole.getvalue()[:-200])
    (tmp_path / "text.png").write_bytes(b"not an image")
    (tmp_path / "empty.png").write_bytes(b"")
    use = TextureUse(str(tmp_path / name), shader="/Looks/M/Tex")
    with pytest.warns(UserWarning, match=f"/Looks/M/Tex.*{name}"):
        _, places = TexturePool().load([use])
    assert not places


def test_exr_without_its_module_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "OpenEXR", None)
    (tmp_path / "a.exr").write_bytes(b"\x76\x2f\x31\x01" + bytes(100))
    with pytest.raises(errors.AssetUnreadable, match=r"usdsdg\[exr\]"):
        image_files.read(str(tmp_path / "a.exr"))


@pytest.mark.parametrize(
    ("names", "kind"), [("RGB", np.float32), ("RGBA", np.float32), ("RGB", np.float16), ("Y", np.float32)]
)
def test_exr_files_keep_their_values(names, kind, tmp_path):
    exr = pytest.importorskip("OpenEXR", reason="OpenEXR is an extra")
    values = np.random.default_rng(0).uniform(-1, 30, (5, 6, len(names))).astype(kind)
    header = {"compression": exr.ZIP_COMPRESSION, "type": exr.scanlineimage}
    with exr.File(header, {names: values[..., 0].copy() if names == "Y" else values.copy()}) as file:
        file.write(str(tmp_path / "a.exr"))
    shown = image_files.read(str(tmp_path / "a.exr")).texels
    expected = np.repeat(values, 3, axis=2) if names == "Y" else values
    np.testing.assert_array_equal(shown[..., : expected.shape[2]], expected.astype(np.float32))
    assert texture(tmp_path / "a.exr").texels.dtype == np.float16
    (tmp_path / "cut.exr").write_bytes((tmp_path / "a.exr").read_bytes()[:200])
    with pytest.raises(errors.AssetUnreadable, match=r"cut\.exr"):
        image_files.read(str(tmp_path / "cut.exr"))


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        ("YA", (0.25, 0.25, 0.25, 0.5)),
        ("AY", (0.5, 0.5, 0.5, 0.25)),
        ("RG", (0.25, 0.5, 0.0, 1.0)),
        ("ZR", (0.5, 0.5, 0.5, 1.0)),
        ("Q", (0.25, 0.25, 0.25, 1.0)),
    ],
)
def test_exr_files_of_other_channels_show_their_gray_or_color(names, expected, tmp_path):
    exr = pytest.importorskip("OpenEXR", reason="OpenEXR is an extra")
    header = {"compression": exr.ZIP_COMPRESSION, "type": exr.scanlineimage}
    channels = {name: np.full((2, 3), value, np.float32) for name, value in zip(names, (0.25, 0.5))}
    with exr.File(header, channels) as file:
        file.write(str(tmp_path / "a.exr"))
    assert (image_files.read(str(tmp_path / "a.exr")).texels == np.array(expected, np.float32)).all()


def png_with_color(values: np.ndarray, depth: int, color: tuple[int, ...]) -> bytes:
    """A PNG of (H, W, 1 or 3) values of `depth` bits in which one color is transparent."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    height, width, channels = values.shape
    bits = ["".join(f"{each:0{depth}b}" for each in row) for row in values.reshape(height, -1).tolist()]
    rows = b"".join(b"\0" + int(row.ljust(-len(row) // 8 * -8, "0"), 2).to_bytes(-(-len(row) // 8)) for row in bits)
    header = struct.pack(">IIBBBBB", width, height, depth, 2 if channels == 3 else 0, 0, 0, 0)
    parts = (b"IHDR", header), (b"tRNS", struct.pack(f">{channels}H", *color)), (b"IDAT", zlib.compress(rows))
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*part) for part in (*parts, (b"IEND", b"")))


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("depth", [1, 2, 4, 8, 16])
def test_one_color_of_a_png_is_transparent(depth, channels, tmp_path):
    """Of every depth that PNG has; bits of the color above that depth do not count."""
    if channels == 3 and depth < 8:
        return
    most = (1 << depth) - 1
    values = np.random.default_rng(depth).integers(0, most + 1, (5, 7, channels))
    values[0, 0], values[0, 1] = most, most
    values[0, 1, -1] -= 1
    for color in (values[0, 0], values[0, 1], values[3, 4]):
        written = tuple((color + (1 << depth) * (depth < 16)).tolist())
        (tmp_path / "a.png").write_bytes(png_with_color(values, depth, written))
        read = image_files.read(str(tmp_path / "a.png"))
        seen = read.texels / np.iinfo(read.texels.dtype).max
        np.testing.assert_allclose(seen[..., :3], np.broadcast_to(values / most, (5, 7, 3)), atol=1e-6)
        np.testing.assert_array_equal(seen[..., 3], (values != color).any(axis=-1))
        assert read.channels == channels + 1


def test_files_inside_a_package_are_read(tmp_path):
    image = io.BytesIO()
    Image.new("RGB", (3, 2), RED).save(image, "PNG")
    with zipfile.ZipFile(tmp_path / "a.usdz", "w", zipfile.ZIP_STORED) as package:
        package.writestr("a.usda", "#usda 1.0\n")
        package.writestr("tex/red.png", image.getvalue())
    inside = f"{tmp_path}/a.usdz[tex/red.png]"
    assert (texture(inside).texels == (*RED, 255)).all()
    assert image_files.modified(inside) == image_files.modified(str(tmp_path / "a.usdz")) != (0, 0)


def test_progress_counts_files(tmp_path):
    calls = []
    uses = [TextureUse(save(tmp_path / f"{k}.png", np.zeros((2, 2, 3), np.uint8))) for k in range(3)]
    TexturePool().load(uses, lambda *step: calls.append(step))
    assert calls == [("textures", 1, 3), ("textures", 2, 3), ("textures", 3, 3)]


@pytest.mark.parametrize("turn", [0.0, 0.5])
def test_another_transform_decodes_nothing_again(turn, tmp_path):
    path = save(tmp_path / "a.png", np.zeros((2, 2, 3), np.uint8))
    pool = TexturePool()
    (before,), _ = pool.load([TextureUse(path)])
    after, places = pool.load([TextureUse(path, transform=UvTransform.of((2.0, 2.0), turn, (0.1, 0.0)))])
    (place,) = places.values()
    assert after[place].texels is before.texels
    assert len(after) == 1


def test_brighter_than_one_and_negative_values_stay(tmp_path):
    values = np.array([[0.001, -0.5], [12.5, 1e9]], np.float32)
    Image.fromarray(values).save(tmp_path / "f.tiff")
    loaded = texture(tmp_path / "f.tiff")
    assert loaded.texels.dtype == np.float16
    np.testing.assert_allclose(loaded.texels[..., 0], [[0.001, -0.5], [12.5, 65504.0]], rtol=1e-3)


@pytest.mark.parametrize(("channel", "expected"), [(0, 0.2), (1, 0.4), (3, 0.8)])
def test_one_channel_stands_for_a_color(channel, expected, tmp_path):
    path = save(tmp_path / "a.png", np.full((2, 2, 4), (51, 102, 153, 204), np.uint8))
    values, _ = flat(path, color_space="raw", broadcast=channel)
    np.testing.assert_allclose(values, [expected] * 3 + [0.8], atol=1e-6)
    coded, _ = flat(path, color_space="sRGB", broadcast=channel)
    linear = expected if channel == 3 else srgb_to_linear(np.array(expected))
    np.testing.assert_allclose(coded[:3], linear, atol=1e-6)


def test_tiles_are_textures_in_one_table(tmp_path):
    for tile in (1001, 1002, 1013):
        save(tmp_path / f"t.{tile}.png", np.full((2, 2, 3), tile - 1000, np.uint8))
    use = TextureUse(f"{tmp_path}/t.<UDIM>.png", "raw", fallback=(0.25, 0.5, 0.75, 1.0))
    (loaded,), places = TexturePool().load([use])
    assert places == {use: 0}
    assert [(number, tile.texels[0, 0, 0]) for number, tile in loaded.tiles] == [(0, 1), (1, 2), (12, 13)]
    np.testing.assert_array_equal(loaded.texels, [[[0.25, 0.5, 0.75, 1.0]]])
    stamp = image_files.modified(use.file)
    save(tmp_path / "t.1014.png", np.zeros((2, 2, 3), np.uint8))
    assert image_files.modified(use.file) != stamp


def test_a_pointer_of_git_lfs_is_told_as_such(tmp_path):
    file = tmp_path / "pointer.png"
    file.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 17497\n")
    with pytest.raises(errors.AssetUnreadable, match=r"pointer\.png: it only points to a file in Git LFS"):
        image_files.read(str(file))
