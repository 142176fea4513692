"""Modal and amodal masks: bit for bit the label pass of a scene with one group alone, and consistent with the AOVs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.render import scenes
from tests.render.bvh.rays import brute_force, world_triangles
from tests.render.images import renderer_of
from tests.stage.cameras.lens_cases import CASES
from tests.stage.geometry.counted_masks import counted_masks
from usdsdg.errors import RenderError
from usdsdg_render.device import view_batches
from usdsdg_render.scene.scene import Instances, Texture

GLASS = 1


def crowded(seed: int, *, count: int = 14, spread: float = 1.5) -> scenes.Scene:
    """Intersecting opaque, glass and cut-out objects, two coincident cubes, and a room around everything."""
    rng = np.random.default_rng(seed)
    texels = np.full((8, 8, 4), 255, np.uint8)
    texels[..., 3] = rng.integers(0, 256, (8, 8))
    materials = [
        scenes.material(),
        scenes.material(transmission=1.0),
        scenes.material(opacity_texture=0, opacity_channel=3),
        scenes.material(opacity=0.3),
    ]
    shapes = [scenes.cube(), scenes.sphere(rings=6), scenes.square()]
    placed = []
    for k in range(count):
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        pose = scenes.moved(rng.uniform(-spread, spread, 3), scale=rng.uniform(0.2, 0.9, 3), rotation=turn)
        placed.append((shapes[k % 3], pose, int(rng.integers(0, 4))))
    # Coplanar: the same cube twice, and a third one whose faces lie in the planes of the first two.
    placed += [(shapes[0], scenes.moved(scale=0.5), 0), (shapes[0], scenes.moved(scale=0.5), GLASS)]
    placed += [(shapes[0], scenes.moved((0.25, 0, 0), scale=(0.25, 0.5, 0.5)), 0)]
    placed += [(shapes[0], scenes.moved(scale=20), 0)]
    return scenes.scene_of(placed, materials=materials, textures=[Texture("leaf", texels, False, 0, 0)])


def groups_of(scene: scenes.Scene) -> list[list[int]]:
    """Groups of one gprim, of several (some in two groups), of none, and of all."""
    count = len(scene.instances.paths)
    return [*([k] for k in range(count)), [0, 3, 5], [3, 4, count - 2], [], list(range(count))]


def alone(scene: scenes.Scene, view, groups, *, glass: str = "surface") -> np.ndarray:
    """Amodal masks (G, H, W) bool, from label passes of scenes with one group alone."""
    everything, masks = scene.instances, []
    for group in groups:
        scene.instances = Instances(
            tuple(everything.paths[k] for k in group),
            everything.prototype[group],
            everything.local_to_world[group],
            everything.slot_offset[group],
            everything.casts_shadow[group],
        )
        scene.touch("instances", "transforms")
        renderer = renderer_of(scene)
        renderer.glass_labels = glass
        masks.append(renderer.labels(view, ["instance"])["instance"] >= 0)
    scene.instances = everything
    scene.touch("instances", "transforms")
    return np.array(masks)


def check(scene: scenes.Scene, view, *, glass: str = "surface") -> None:
    groups = groups_of(scene)
    renderer = renderer_of(scene)
    renderer.glass_labels = glass
    instance = renderer.labels(view, ["instance"])["instance"]
    found = renderer.pixel_masks(view, groups, instance=instance)
    masks = alone(scene, view, groups, glass=glass)
    shown = np.array([np.isin(instance, group) for group in groups])
    np.testing.assert_array_equal([found.mask(k) for k in range(len(groups))], masks)
    np.testing.assert_array_equal(found.visible, shown.sum((1, 2)))
    for mask, row in zip(masks, found.coverage, strict=True):
        y, x = np.nonzero(mask)
        box = [x.min(), y.min(), x.max(), y.max()] if len(x) else [-1] * 4
        assert row.tolist() == [len(x), *box]
    group, y, x = found.hidden()
    hidden = np.zeros_like(masks)
    hidden[group, y, x] = True
    np.testing.assert_array_equal(hidden, masks & ~shown)
    assert len(group) == hidden.sum()


@pytest.mark.parametrize("glass", ["surface", "behind"])
@pytest.mark.parametrize("seed", range(4))
def test_amodal_masks_are_what_each_group_covers_alone(seed, glass):
    scene = crowded(seed)
    check(scene, scenes.view_from((4, -5, 2), size=(131, 43)), glass=glass)


@pytest.mark.parametrize("seed", range(6))
def test_masks_with_the_camera_among_the_objects(seed):
    # Boxes around the camera, across its near plane, behind it, and cut by the clipping range.
    rng = np.random.default_rng(seed)
    eye, target = rng.uniform(-1, 1, (2, 3))
    near = float(rng.choice([0.001, 0.1, 0.7]))
    view = scenes.view_from(
        eye, target, size=(70, 37), clipping_range=(near, 4.0), horizontal_aperture_offset=3.0,
        focal_length=float(rng.choice([4.0, 20.0])),
    )  # fmt: skip
    check(crowded(seed, count=20), view)


@pytest.mark.parametrize(("eye", "near"), [((4, -5, 2), 0.001), ((0.4, -0.5, 0.2), -10.0)])
def test_masks_of_orthographic_cameras(eye, near):
    orthographic = dict(projection_type="orthographic", horizontal_aperture=50.0, clipping_range=(near, 100.0))
    check(crowded(7), scenes.view_from(eye, size=(65, 40), **orthographic))


@pytest.mark.parametrize(("scale", "offset"), [(1e-3, 0.0), (1.0, 3000.0), (1e3, 1e5)])
def test_masks_far_from_the_origin_and_at_any_scale(scale, offset):
    scene = crowded(3)
    scene.instances.local_to_world[:, :, :3] *= scale
    scene.instances.local_to_world[:, 3, :3] += offset
    eye = np.array([2, -2.5, 1]) * scale + offset
    view = scenes.view_from(eye, np.full(3, offset), size=(66, 40), clipping_range=(1e-3 * scale, 1e3 * scale))
    check(scene, view)


def test_masks_equal_brute_force_over_all_triangles():
    scene = crowded(11, count=9)
    # Opaque, so that triangles alone decide.
    scene.materials["opacity_texture"], scene.materials["opacity"] = -1, 1.0
    view = scenes.view_from((3, -4, 2), size=(40, 30))
    triangles, owners = world_triangles(scene)
    x, y = np.meshgrid(np.arange(40) + 0.5, np.arange(30) + 0.5)
    directions = np.stack([(x - view.cx) / view.fx, (view.cy - y) / view.fy, np.full_like(x, -1)], -1).reshape(-1, 3)
    directions = directions @ view.local_to_world[:3, :3]
    origins = np.broadcast_to(view.local_to_world[3, :3], directions.shape)
    groups = [[k] for k in range(len(scene.instances.paths))]
    found = renderer_of(scene).pixel_masks(view, groups)
    certain = 0
    for k in range(len(groups)):
        t, doubt = brute_force(triangles[owners == k], origins, directions)
        clear = doubt > 1e-4
        np.testing.assert_array_equal(found.mask(k).ravel()[clear], np.isfinite(t)[clear])
        certain += clear.sum()
    assert certain > 0.98 * 1200 * len(groups)


def test_coincident_objects_all_count_and_one_of_them_occludes_the_others():
    cube = scenes.cube()
    scene = scenes.scene_of([(cube, scenes.moved(), 0)] * 3)
    view = scenes.view_from((0, -6, 0))
    found = renderer_of(scene).pixel_masks(view, [[0], [1], [2], [0, 1, 2]])
    pixels = found.coverage[:, 0]
    assert pixels[0] > 50
    assert (pixels == pixels[0]).all()
    assert found.visible[:3].sum() == found.visible[3] == pixels[0]
    hidden = np.bincount(found.hidden()[0], minlength=4)
    assert (hidden == pixels - found.visible).all()


def test_masks_do_not_depend_on_the_number_of_threads():
    scene = crowded(5)
    view, groups = scenes.view_from((4, -5, 2), size=(131, 90)), groups_of(scene)
    words = [renderer_of(scene, threads=threads).pixel_masks(view, groups).words.tobytes() for threads in (1, 3, 3)]
    assert words[0] == words[1] == words[2]


def test_labels_pass_through_glass_in_mode_behind():
    def seen(material, glass):
        placed = [(scenes.square(), scenes.moved((0, 0, 2)), 1), (scenes.square(), scenes.moved(scale=3), 0)]
        texels = np.full((2, 2, 4), 200, np.uint8)
        scene = scenes.scene_of(
            placed, materials=[scenes.material(), material], textures=[Texture("veil", texels, False, 0, 0)]
        )
        renderer = renderer_of(scene)
        renderer.glass_labels = glass
        labels = renderer.labels(scenes.view_from((0, 0, 8), up=(0, 1, 0)), ["instance", "position", "bump_normals"])
        front = labels["instance"][12, 16]
        # All AOVs belong to the same surface.
        assert labels["position"][12, 16, 2] == pytest.approx(2 * (1 - front))
        assert labels["bump_normals"][12, 16, 2] == pytest.approx(1)
        return int(front)

    opaque, clear = scenes.material(), scenes.material(transmission=1.0)
    assert [seen(opaque, glass) for glass in ("surface", "behind")] == [0, 0]
    assert [seen(clear, glass) for glass in ("surface", "behind")] == [0, 1]
    assert [seen(scenes.material(opacity=0.2), glass) for glass in ("surface", "behind")] == [0, 1]
    assert [seen(scenes.material(opacity=0.7), glass) for glass in ("surface", "behind")] == [0, 0]
    # Cut-outs are holes in both modes, and the opaque part of a leaf is visible in both.
    leaf = scenes.material(opacity_texture=0, opacity_channel=3)
    assert [seen(leaf, glass) for glass in ("surface", "behind")] == [0, 0]
    hole = scenes.material(opacity_texture=0, opacity_channel=3, opacity_threshold=0.9)
    assert [seen(hole, glass) for glass in ("surface", "behind")] == [1, 1]


def test_unknown_glass_modes_raise():
    renderer = renderer_of(crowded(0))
    assert renderer.glass_labels == "surface"
    with pytest.raises(RenderError, match="'through'; it may be 'surface' or 'behind'"):
        renderer.glass_labels = "through"
    assert renderer.glass_labels == "surface"


def test_faces_barycentrics_and_uvs_reproduce_the_hit_point():
    rng = np.random.default_rng(2)
    square = scenes.square()
    bent = scenes.prototype(square.points, square.triangles, uvs=rng.uniform(-1, 2, (2, 3, 2)))
    shapes = [bent, scenes.cube(), scenes.sphere(rings=7)]
    placed = [(shape, scenes.moved(rng.uniform(-1, 1, 3), scale=0.8), 0) for shape in shapes]
    scene = scenes.scene_of(placed)
    names = ["instance", "prim", "barycentrics", "uv", "position"]
    labels = renderer_of(scene).labels(scenes.view_from((1, -3, 4)), names)
    hit = labels["instance"] >= 0
    assert set(labels["instance"][hit]) == {0, 1, 2}
    assert (labels["prim"][~hit] == -1).all()
    for y, x in np.argwhere(hit):
        which = labels["instance"][y, x]
        prototype, matrix = scene.prototypes[which], scene.instances.local_to_world[which]
        face, weights = labels["prim"][y, x], labels["barycentrics"][y, x].astype(np.float64)
        assert weights.min() > -1e-5
        assert weights.sum() == pytest.approx(1, abs=1e-6)
        point = weights @ prototype.points[prototype.triangles[face]] @ matrix[:3, :3] + matrix[3, :3]
        np.testing.assert_allclose(labels["position"][y, x], point, atol=2e-5)
        np.testing.assert_allclose(labels["uv"][y, x], weights @ prototype.uvs[face], atol=1e-5)


def test_the_prim_aov_numbers_faces_of_the_mesh_not_triangles():
    from pxr import Usd, UsdGeom

    from usdsdg_render.renderer import WarpRenderer

    stage = Usd.Stage.CreateInMemory()
    mesh = UsdGeom.Mesh.Define(stage, "/Mesh")
    # A row of three quads and a pentagon, of which the second quad is a hole.
    points = [(x, y, 0) for x in range(4) for y in (0, 1)] + [(4, 0, 0), (5, 0.5, 0), (4, 1, 0)]
    mesh.CreatePointsAttr(points)
    mesh.CreateFaceVertexCountsAttr([4, 4, 4, 5])
    mesh.CreateFaceVertexIndicesAttr([0, 2, 3, 1, 2, 4, 5, 3, 4, 6, 7, 5, 6, 8, 9, 10, 7])
    mesh.CreateHoleIndicesAttr([1])
    mesh.CreateSubdivisionSchemeAttr("none")
    renderer = WarpRenderer(stage, device="cpu")
    renderer.sync()
    view = scenes.view_from((2.5, 0.5, 9), (2.5, 0.5, 0), up=(0, 1, 0), size=(60, 20))
    labels = renderer.labels(view, ["instance", "prim", "position"])
    hit = labels["instance"] >= 0
    expected = np.clip(np.floor(labels["position"][..., 0]), 0, 3).astype(int)
    assert set(expected[hit]) == {0, 2, 3}
    np.testing.assert_array_equal(labels["prim"][hit], expected[hit])


@pytest.mark.parametrize("at_once", [1 << 16, 70])
def test_masks_of_a_batch_are_those_of_each_view_alone(at_once, monkeypatch):
    monkeypatch.setattr(view_batches, "MASKS", at_once)
    scene = crowded(2, count=30)
    flat = [scenes.view_from(eye, size=(90, 61)) for eye in [(4, -5, 2), (0.2, 0.1, 0), (-3, 4, -5)]]
    sharing = groups_of(scene)
    for views in (flat, [*flat[:2], replace(flat[2], **CASES["fisheyeKannalaBrandtK3"])]):
        for groups in (sharing, sharing[: len(scene.instances.paths)], [[3], [], [5, 6], [0]]):
            renderer = renderer_of(scene)
            labels, found = renderer.labels_and_masks(views, ["distance_to_camera"], groups)
            for view, aovs, together in zip(views, labels, found, strict=True):
                alone = renderer.pixel_masks(view, groups)
                np.testing.assert_array_equal(together.coverage, alone.coverage)
                np.testing.assert_array_equal(together.visible, alone.visible)
                assert together.words.tobytes() == alone.words.tobytes()
                np.testing.assert_array_equal(
                    aovs["distance_to_camera"], renderer.labels(view, aovs)["distance_to_camera"]
                )


def test_coverage_counts_match_the_masks():
    scene = crowded(8, count=25)
    found = renderer_of(scene).pixel_masks(scenes.view_from((3, -4, 2), size=(200, 77)), groups_of(scene))
    counted = counted_masks(found.shape, found.count, found.words)
    assert (counted.coverage[:, 0] > 0).sum() > 10
    np.testing.assert_array_equal(found.coverage, counted.coverage)
    np.testing.assert_array_equal(found.visible, counted.visible)
