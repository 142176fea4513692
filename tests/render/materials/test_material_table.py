"""The table of materials, over many frames of materials that come, change and go."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from usdsdg_render.images.textures import TexturePool, TextureUse
from usdsdg_render.materials.display_color import DisplayColor
from usdsdg_render.materials.material_rows import PLAIN, material_row
from usdsdg_render.materials.material_table import MaterialTable
from usdsdg_render.materials.shading import Input, Material
from usdsdg_render.scene.scene import MATERIAL


@pytest.fixture
def files(tmp_path):
    for k in range(4):
        Image.fromarray(np.full((2, 2, 3), k, np.uint8)).save(tmp_path / f"{k}.png")
    return [str(tmp_path / f"{k}.png") for k in range(4)]


def any_input(rng, width, files):
    use = TextureUse(files[rng.integers(len(files))]) if rng.random() < 0.3 else None
    return Input(tuple(rng.uniform(-0.5, 1.5, width).tolist()), use, int(rng.integers(3)) if width == 1 else 0)


def any_fields(rng, files):
    return {
        "base_color": any_input(rng, 3, files),
        "roughness": any_input(rng, 1, files),
        "opacity_threshold": float(rng.uniform(-0.5, 1.5)),
        "normal_scale": float(rng.uniform(-3, 3)),
        "normal": TextureUse(files[0]) if rng.random() < 0.3 else None,
        "uv_primvar": "st",
    }


def any_material(rng, files):
    if rng.random() < 0.5:
        return DisplayColor(tuple(rng.integers(0, 3, 3).astype(float).tolist()), float(rng.integers(0, 3)))
    return Material(**any_fields(rng, files))


@pytest.mark.parametrize("seed", range(6))
def test_rows_are_those_of_their_materials(seed, files):
    rng = np.random.default_rng(seed)
    table, pool, textures = MaterialTable(), TexturePool(), []
    held = []  # (material, row) of each user
    for _ in range(60):
        for _ in range(rng.integers(1, 8)):
            action = rng.random()
            if action < 0.4 or not held:
                known = held and rng.random() < 0.3
                material = held[rng.integers(len(held))][0] if known else any_material(rng, files)
                held.append((material, table.take(material)))
            elif action < 0.7:
                _, row = held.pop(rng.integers(len(held)))
                table.release([row])
            else:
                before = held[rng.integers(len(held))][0]
                if isinstance(before, Material):
                    fields = any_fields(rng, files)
                    some = {name: fields[name] for name in rng.permutation(list(fields))[: rng.integers(1, 4)]}
                    after = before.with_fields(some)
                    assert after == replace(before, **some)
                    table.replace(before, after, some.keys())
                    held = [(after if material is before else material, row) for material, row in held]
        rows, found = table.write(pool)
        textures = textures if found is None else found
        indices = {TextureUse(texture.path): k for k, texture in enumerate(textures)}
        users = dict.fromkeys(range(len(table)), PLAIN)
        for material, row in held:
            whole = material.material if isinstance(material, DisplayColor) else material
            users[row] = np.array(material_row(whole, indices), MATERIAL)
        for row, expected in users.items():
            assert rows[row].tobytes() == expected.tobytes()


def test_materials_that_differ_from_frame_to_frame_stay_in_their_rows():
    table, rng = MaterialTable(), np.random.default_rng(0)
    rows = [table.take(DisplayColor((0.1 * k, 0.0, 0.0))) for k in range(8)]
    for _ in range(50):
        table.write(TexturePool())
        table.release(rows)
        assert [table.take(DisplayColor(tuple(rng.random(3).tolist()))) for _ in rows] == rows
    assert len(table) == 8
