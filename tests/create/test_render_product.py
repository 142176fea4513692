"""Render products: reuse, names, handles and errors."""

import threading

import pytest
from pxr import Gf, Usd, UsdRender

import usdsdg as rep
from usdsdg.errors import ArgumentError, BadPrim, GraphError, RenderError, UsdsdgError, UsdsdgWarning
from usdsdg.session.render_products import products
from usdsdg.session.settings.store import get_settings
from usdsdg.utils import viewport_manager


@pytest.fixture
def cameras(stage):
    return rep.create.camera(count=2)


def test_a_product_is_a_prim_of_the_session_layer(stage, cameras):
    product = rep.create.render_product(cameras.prims[1], (640, 480))
    assert product.path == "/Render/HydraTextures/Replicator"
    prim = UsdRender.Product(stage.GetPrimAtPath(product.path))
    assert prim.GetResolutionAttr().Get() == (640, 480)
    assert [str(path) for path in prim.GetCameraRel().GetTargets()] == [f"{cameras.prims[1]}/Camera"]
    assert not stage.GetRootLayer().GetPrimAtPath(product.path)
    handle = product.hydra_texture
    assert (handle.width, handle.height) == (640, 480)
    assert handle.get_render_product_path() == product.path
    assert (handle.get_width(), handle.get_height()) == (640, 480)
    assert (handle.get_name(), handle.get_camera_path()) == ("Replicator", f"{cameras.prims[1]}/Camera")
    assert handle.hydra_engine == "rtx"


@pytest.mark.parametrize(
    ("prefix", "path"),
    [
        ("OmniverseKit/HydraTextures/", "/Render/OmniverseKit/HydraTextures/mine"),
        ("", f"/Render/{viewport_manager.LEGACY_RP_PREFIX}mine"),
    ],
)
def test_a_setting_says_where_products_are(stage, cameras, prefix, path):
    settings = get_settings()
    made = rep.create.render_product(cameras.prims[1], (8, 8), name="mine")
    assert made.path == f"/Render/{settings.get(viewport_manager.RP_PREFIX_SETTING)}mine"
    settings.set(viewport_manager.RP_PREFIX_SETTING, prefix)
    assert rep.create.render_product(cameras.prims[1], (8, 8), name="mine").path == path


def test_a_place_of_products_that_is_no_path_is_named(stage, cameras):
    get_settings().set(viewport_manager.RP_PREFIX_SETTING, "my products/")
    with pytest.raises(ArgumentError, match="path/prefix is 'my products/'; expected names"):
        rep.create.render_product(cameras.prims[0], (8, 8))


def test_a_product_is_reused_unless_a_new_one_is_requested(stage, cameras):
    one = cameras.prims[0]
    first = rep.create.render_product(one, (8, 8))
    assert rep.create.render_product(stage.GetPrimAtPath(f"{one}/Camera"), [8, 8]) is first
    others = [
        rep.create.render_product(one, (8, 9)),
        rep.create.render_product(cameras.prims[1], (8, 8)),
        rep.create.render_product(one, (8, 8), force_new=True),
        rep.create.render_product(one, (8, 8), name="mine"),
        rep.create.render_product(one, (8, 8), name="mine"),
    ]
    names = [product.path.rpartition("/")[2] for product in (first, *others)]
    assert names == ["Replicator", "Replicator_01", "Replicator_02", "Replicator_03", "mine", "mine_01"]


def test_several_cameras_get_a_product_each(stage, cameras):
    products = rep.create.render_product(cameras, (8, 8), name=["left", "right"])
    assert [product.path.rpartition("/")[2] for product in products] == ["left", "right"]
    assert [product.camera_path for product in products] == [f"{path}/Camera" for path in cameras.prims]
    same = rep.create.render_product([cameras.prims[0], cameras.prims[1]], (8, 8), name="both")
    assert [product.path.rpartition("/")[2] for product in same] == ["both", "both_01"]


def test_a_destroyed_product_is_removed(stage, cameras):
    product = rep.create.render_product(cameras.prims[0], (8, 8))
    product.destroy()
    assert products() == []
    assert rep.create.render_product(cameras.prims[0], (8, 8)) is not product


def test_a_destroyed_product_leaves_its_name_to_the_next(stage, cameras):
    paths = []
    for _ in range(2):
        product = rep.create.render_product(cameras.prims[0], (8, 8), name="B")
        paths.append(product.path)
        product.destroy()
        assert not stage.GetPrimAtPath(product.path)
        product.destroy()
    assert paths == ["/Render/HydraTextures/B"] * 2


@pytest.mark.parametrize("reader", ["writer", "annotator"])
def test_the_readers_of_a_destroyed_product_get_no_other_of_its_name(stage, cameras, reader, tmp_path):
    product = rep.create.render_product(cameras.prims[0], (8, 8), name="B")
    if reader == "writer":
        rep.writers.get("BasicWriter", {"output_dir": str(tmp_path), "rgb": True}).attach(product)
    else:
        annotator = rep.annotators.get("rgb").attach(product)
    product.destroy()
    assert rep.create.render_product(cameras.prims[1], (8, 8), name="B").path == f"{product.path}_01"
    if reader == "annotator":
        assert annotator.render_product == product.path


def test_a_finalizer_leaves_the_stage_as_it_is(stage, cameras):
    product = rep.create.render_product(cameras.prims[0], (8, 8))
    ended = threading.Thread(target=product.destroy)
    ended.start()
    ended.join()
    assert products() == []
    assert stage.GetPrimAtPath(product.path)


def test_a_destroyed_product_of_an_earlier_stage_leaves_those_of_the_stage(stage, cameras):
    earlier = rep.create.render_product(cameras.prims[0], (8, 8))
    rep.new_stage()
    product = rep.create.render_product(rep.create.camera(), (8, 8))
    assert product.path == earlier.path
    earlier.destroy()
    assert products() == [product]


@pytest.mark.parametrize("resolution", ["big", (8,), (8, 8, 8), (8.5, 8), None, ("a", 8)])
def test_a_resolution_is_two_whole_numbers(stage, cameras, resolution):
    with pytest.raises(TypeError, match=r"resolution must be \(width, height\)"):
        rep.create.render_product(cameras, resolution)


def test_invalid_render_products_raise_errors(stage, cameras):
    with pytest.raises(RenderError, match="-8 x 8 pixels cannot be made"):
        rep.create.render_product(cameras, (-8, 8))
    with pytest.raises(BadPrim, match=r"/World/Kamera is not on the stage; cameras on the stage: .*/Camera"):
        rep.create.render_product("/World/Kamera", (8, 8))
    with pytest.raises(BadPrim, match="/World is a Xform without a camera in it"):
        rep.create.render_product("/World", (8, 8))
    with pytest.raises(BadPrim, match=r"camera is \[\]; give at least one"):
        rep.create.render_product([], (8, 8))
    with pytest.raises(GraphError, match="name has 1 entry for 2 cameras"):
        rep.create.render_product(cameras, (8, 8), name=["left"])


def test_names_and_resolutions_are_converted(stage, cameras):
    with pytest.warns(UsdsdgWarning, match="it is called front_left instead"):
        product = rep.create.render_product(cameras.prims[0], ("32", "16"), name="front-left")
    assert product.path == "/Render/HydraTextures/front_left"
    assert product.resolution == (32, 16)


def test_sizes_and_cameras_can_be_set_one_by_one(stage, cameras):
    product = rep.create.render_product(cameras.prims[0], (32, 16))
    product.hydra_texture.set_width(24)
    product.hydra_texture.set_height(12)
    product.hydra_texture.set_camera_path(f"{cameras.prims[1]}/Camera")
    assert (product.resolution, product.camera_path) == ((24, 12), f"{cameras.prims[1]}/Camera")
    prim = UsdRender.Product(stage.GetPrimAtPath(product.path))
    assert prim.GetResolutionAttr().Get() == (24, 12)
    with pytest.raises(RenderError):
        product.set_width(0)


def test_a_product_shows_what_its_prim_says(stage, cameras):
    """As scripts change it: in the session layer, where the prim is."""
    product = rep.create.render_product(cameras.prims[0], (64, 48))
    rgb = rep.annotators.get("rgb")
    rgb.attach(product)
    rep.orchestrator.step()
    prim = UsdRender.Product(stage.GetPrimAtPath(product.path))
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        prim.GetResolutionAttr().Set(Gf.Vec2i(40, 20))
        prim.GetCameraRel().SetTargets([f"{cameras.prims[1]}/Camera"])
    rep.orchestrator.step()
    assert rgb.get_data().shape == (20, 40, 4)
    assert (product.width, product.height, product.camera_path) == (40, 20, f"{cameras.prims[1]}/Camera")
    product.set_resolution((32, 16))
    assert prim.GetResolutionAttr().Get() == (32, 16)
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        prim.GetResolutionAttr().Set(Gf.Vec2i(0, 20))
    with pytest.raises(RenderError, match="0 x 20 pixels"):
        _ = product.resolution


def test_a_product_of_an_earlier_stage_is_not_that_of_this_one_at_its_path(cameras):
    earlier = rep.create.render_product(cameras.prims[0], (64, 48))
    rep.new_stage()
    later = rep.create.render_product(rep.create.camera(), (8, 8))
    assert later.path == earlier.path
    assert (earlier.resolution, later.resolution) == ((64, 48), (8, 8))


def test_a_product_of_an_earlier_stage_is_not_attached_to(cameras, tmp_path):
    earlier = rep.create.render_product(cameras.prims[0], (64, 48))
    rep.new_stage()
    annotator, writer = rep.annotators.get("rgb"), rep.writers.get("BasicWriter")
    writer.initialize(output_dir=str(tmp_path), rgb=True)
    with pytest.raises(BadPrim, match="there is no render product"):
        annotator.attach(earlier)
    later = rep.create.render_product(rep.create.camera(), (8, 8))
    assert later.path == earlier.path
    for attach in (annotator.attach, writer.attach):
        with pytest.raises(BadPrim, match=f"^the render product given was {earlier.path} before a new stage or"):
            attach([earlier])
        attach([later])
        attach(later.path)


def test_a_single_number_is_an_error_of_the_project(stage, cameras):
    with pytest.raises(UsdsdgError, match=r"resolution must be \(width, height\) in whole pixels, got 256"):
        rep.create.render_product(cameras, 256)
    with pytest.raises(UsdsdgError, match=r"tile_resolution must be"):
        rep.create.render_product_tiled(cameras, 256)


def test_scripts_destroy_all_render_products_at_once(stage):
    cameras = [rep.create.camera() for _ in range(2)]
    products = [rep.create.render_product(camera, (8, 8)) for camera in cameras]
    annotator = rep.annotators.get("rgb")
    annotator.attach(products[0])
    paths = [product.path for product in products]
    rep.vp_manager.destroy_hydra_textures("Replicator")
    with pytest.raises(BadPrim, match="there is no render product"):
        rep.annotators.get("rgb").attach(paths[1])
    # The prim of a product that an annotator reads stays, so that no other one gets its path.
    assert [bool(stage.GetPrimAtPath(path)) for path in paths] == [True, False]
    assert rep.create.render_product(cameras[1], (8, 8)).path == paths[1]
    rep.vp_manager.destroy_hydra_textures()
    assert not stage.GetPrimAtPath(paths[1])
