"""Every place that takes an asset takes a mesh file, converted once."""

import sys
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from pxr import Usd, UsdGeom

import usdsdg as rep
from usdsdg import compat
from usdsdg.errors import AssetUnreadable, UsdsdgWarning
from usdsdg.meshes import cache
from usdsdg.meshes.conversion import Options
from usdsdg.session.stage_context import current_stage, open_stage
from usdsdg.stage import assets
from usdsdg.stage.semantics.labels import get_labels

pytestmark = pytest.mark.usefixtures("own_cache")


@pytest.fixture
def files(stage, tmp_path):
    """Two mesh files, bolt.obj and nut.glb."""
    trimesh.creation.box((0.1, 0.2, 0.3)).export(tmp_path / "bolt.obj")
    trimesh.creation.icosphere(subdivisions=2, radius=0.1).export(tmp_path / "nut.glb")
    return [str(tmp_path / "bolt.obj"), str(tmp_path / "nut.glb")]


@pytest.fixture
def conversions(monkeypatch):
    """The files that are converted, in order."""
    done = []
    inner = cache.convert
    monkeypatch.setattr(cache, "convert", lambda source, *rest: done.append(source.name) or inner(source, *rest))
    return done


def labels_below(path):
    prims = Usd.PrimRange(current_stage().GetPrimAtPath(path))
    return [labels for prim in prims if (labels := get_labels(prim))]


def size(path):
    bound = UsdGeom.BBoxCache(Usd.TimeCode.Default(), ["default"]).ComputeWorldBound(
        current_stage().GetPrimAtPath(path)
    )
    return np.array(bound.ComputeAlignedRange().GetSize())


def test_from_usd_labels_a_mesh_by_its_name_unless_told(files):
    [path] = rep.create.from_usd(files[0]).prims
    assert labels_below(path) == [{"class": ["bolt"]}]
    assert np.allclose(size(path), (0.1, 0.3, 0.2))  # Y up in the file
    [path] = rep.create.from_usd(files[0], semantics=[("class", "screw")]).prims
    assert labels_below(path) == [{"class": ["screw"]}]


def test_units_and_axes_are_those_of_the_stage(files):
    rep.settings.set_stage_meters_per_unit(0.01)
    rep.settings.set_stage_up_axis("Y")
    [path] = rep.create.from_usd(files[0]).prims
    assert np.allclose(size(path), (10, 20, 30))


def test_folders_hold_meshes_too(files, tmp_path):
    assert len(rep.create.from_dir(str(tmp_path)).prims) == 2
    assert [file.rsplit("/", 1)[1] for file in rep.utils.get_usd_files(str(tmp_path))] == ["bolt.obj", "nut.glb"]
    assert [labels_below(path) for path in rep.create.from_dir(str(tmp_path), semantics=[("class", "x")]).prims] == [
        [{"class": ["x"]}]
    ] * 2


@pytest.mark.parametrize("mode", ["scene_instance", "reference", "point_instance"])
def test_instances_of_meshes(files, mode):
    with rep.trigger.on_frame():
        item = rep.randomizer.instantiate(files, size=4, mode=mode)
    rep.orchestrator.step()
    stage = current_stage()
    everything = Usd.PrimRange(stage.GetPrimAtPath(item.prims[0]).GetParent(), Usd.TraverseInstanceProxies())
    assert {name for prim in everything for name in get_labels(prim).get("class", [])} <= {"bolt", "nut"}
    assert any(prim.IsA(UsdGeom.Mesh) for prim in Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()))


def test_functional_references_and_stages(files):
    prim = rep.functional.create.reference(usd_path=files[1])
    assert np.allclose(size(prim.GetPath()), 0.2, atol=0.01)
    stage = open_stage(files[0])
    assert stage.GetDefaultPrim().GetName() == "bolt"


def test_references_that_scripts_author_with_pxr(files):
    before = (list(sys.meta_path), set(sys.modules))
    compat.install()
    try:
        prim = current_stage().DefinePrim("/World/Bolt")
        assert prim.GetReferences().AddReference(files[0])
        assert np.allclose(size("/World/Bolt"), (0.1, 0.3, 0.2))
        assert Usd.Stage.Open(files[0]).GetDefaultPrim().GetName() == "bolt"
    finally:
        sys.meta_path[:] = before[0]


def test_a_mesh_is_converted_once_until_its_content_changes(files, conversions, tmp_path):
    for _ in range(3):
        assets.resolve(files[0])
    assert conversions == ["bolt.obj"]
    (tmp_path / "bolt.mtl").write_text("newmtl red\nKd 1 0 0\n")
    text = (tmp_path / "bolt.obj").read_text()
    (tmp_path / "bolt.obj").write_text(f"mtllib bolt.mtl\nusemtl red\n{text}")
    assets.resolve(files[0])
    (tmp_path / "bolt.mtl").write_text("newmtl red\nKd 0 1 0\n")
    for _ in range(2):
        file = assets.resolve(files[0])
    assert conversions == ["bolt.obj"] * 3
    opened = Usd.Stage.Open(file)
    [shader] = [prim for prim in opened.Traverse() if prim.GetName() == "Surface"]
    assert shader.GetAttribute("inputs:diffuseColor").Get() == (0, 1, 0)


def test_a_broken_mesh_is_an_error_and_repairs_are_warnings(files, tmp_path):
    (tmp_path / "cut.glb").write_bytes(b"glTF\x02\x00\x00\x00\xff\xff\x00\x00")
    with pytest.raises(AssetUnreadable, match=r"cut.glb cannot be read as GLB"):
        rep.create.from_usd(str(tmp_path / "cut.glb"))
    (tmp_path / "twice.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 3\n")
    with pytest.warns(UsdsdgWarning, match=r"twice.obj: removed 1 doubled triangles"):
        rep.create.from_usd(str(tmp_path / "twice.obj"))


@pytest.mark.parametrize("damage", ["cut", "empty", "flipped", "removed"])
def test_a_converted_mesh_that_is_damaged_is_converted_again(damage, files, conversions):
    made = Path(cache.converted(files[0], Options()))
    whole = made.read_bytes()
    damaged = {"cut": whole[: len(whole) // 2], "empty": b"", "removed": None}
    changed = damaged.get(damage, whole[:-40] + bytes([whole[-40] ^ 1]) + whole[-39:])
    made.unlink()
    if changed is not None:
        made.write_bytes(changed)
    with pytest.warns(UsdsdgWarning, match="is converted again") if damage != "removed" else nullcontext():
        assert cache.converted(files[0], Options()) == str(made)
    assert made.read_bytes() == whole
    assert conversions == ["bolt.obj"] * 2
    assert cache.converted(files[0], Options()) == str(made)
    assert conversions == ["bolt.obj"] * 2


def test_a_texture_of_a_converted_mesh_that_is_damaged_is_made_again(stage, tmp_path):
    picture = Image.fromarray(np.arange(48, dtype=np.uint8).reshape(4, 4, 3))
    ball = trimesh.creation.icosphere(subdivisions=1)
    ball.visual = trimesh.visual.TextureVisuals(uv=ball.vertices[:, :2], image=picture)
    ball.export(tmp_path / "ball.glb")
    made = Path(cache.converted(tmp_path / "ball.glb", Options()))
    [texture] = [each for each in made.parent.rglob("*") if each.suffix in (".png", ".jpg")]
    whole = texture.read_bytes()
    texture.write_bytes(whole[:20])
    with pytest.warns(UsdsdgWarning, match="is converted again"):
        cache.converted(tmp_path / "ball.glb", Options())
    assert texture.read_bytes() == whole
