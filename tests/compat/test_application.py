"""The application: Kit's arguments, launch configuration, extensions, files by URL, viewport cameras, units."""

import asyncio
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom

import usdsdg as rep
from usdsdg import compat
from usdsdg.compat import kit_arguments
from usdsdg.compat.carb import dictionary
from usdsdg.compat.carb.eventdispatcher import get_eventdispatcher
from usdsdg.compat.isaacsim.simulation_app import SimulationApp
from usdsdg.compat.isaacsim.test.utils.file_validation import get_folder_file_summary
from usdsdg.compat.omni import client
from usdsdg.compat.omni.isaac import nucleus
from usdsdg.compat.omni.kit.app import SettingChangeSubscription, get_app
from usdsdg.compat.omni.kit.viewport.utility import get_active_viewport
from usdsdg.compat.omni.metrics.assembler.core import get_metrics_assembler_interface
from usdsdg.compat.omni.timeline import (
    GLOBAL_EVENT_CURRENT_TIME_TICKED,
    GLOBAL_EVENT_CURRENT_TIME_TICKED_PERMANENT,
    TimelineEventType,
    get_timeline_interface,
)
from usdsdg.compat.omni.usd import get_context
from usdsdg.errors import AssetError, AssetNotFound, BadPrim, BadValue, Unsupported
from usdsdg.session import stage_context
from usdsdg.session.settings.store import ChangeEventType, get_settings
from usdsdg.stage import assets
from usdsdg.stage.cameras import viewport_cameras

PERSPECTIVE = "/OmniverseKit_Persp"


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("true", True), ("False", False), ("3", 3), ("-0.5", -0.5), ("1e3", 1000.0), ("'7'", "7"), ("x", "x"),
        ("[1,2.5,x]", [1, 2.5, "x"]), ("", ""), ("/tmp/a=b", "/tmp/a=b"),
    ],
)  # fmt: skip
def test_arguments_of_kit_are_typed_settings(stage, text, value):
    kit_arguments.apply(["--mine", "4", f"--/app/test/key={text}", "--/app/flag"])
    found = get_settings().get("/app/test/key")
    assert (found, type(found)) == (value, type(value))
    assert get_settings().get("/app/flag") is True


def test_the_launch_configuration_sets_what_it_gives_and_opens_a_stage(stage, tmp_path, monkeypatch):
    file = tmp_path / "scene.usda"
    scene = Usd.Stage.CreateNew(str(file))
    UsdGeom.Cube.Define(scene, "/here")
    scene.Save()
    monkeypatch.setattr(sys, "argv", ["script.py", "--/rtx/pathtracing/maxBounces=7"])
    app = SimulationApp({"renderer": "pathtracing", "samples_per_pixel_per_frame": 9, "width": 320, "height": 240,
                         "open_usd": str(file), "extra_args": ["--/app/my=1.5"]})  # fmt: skip
    settings = get_settings()
    assert [
        settings.get(f"/rtx/{key}") for key in ("rendermode", "pathtracing/totalSpp", "pathtracing/maxBounces")
    ] == ["PathTracing", 9, 7]
    assert settings.get("/app/my") == 1.5
    assert settings.get("/rtx/pathtracing/maxSpecularAndTransmissionBounces") == 6
    assert get_active_viewport().resolution == (320, 240)
    assert get_context().get_stage().GetPrimAtPath("/here")
    with pytest.raises(AssetNotFound):
        SimulationApp({"open_usd": str(tmp_path / "nowhere.usd")})
    with pytest.raises(SystemExit) as ended:
        app.close(exit_code=3)
    assert ended.value.code == 3


def test_extensions_are_enabled_where_their_modules_are(stage, tmp_path):
    compat.install()
    manager = get_app().get_extension_manager()
    assert manager.is_extension_enabled("isaacsim.benchmark.services")
    assert not manager.is_extension_enabled("omni.usd.metrics.assembler")
    manager.set_extension_enabled_immediate("omni.usd.metrics.assembler", True)
    assert manager.get_enabled_extension_id("omni.usd.metrics.assembler") == "omni.usd.metrics.assembler-0.0.0"
    with pytest.raises(Unsupported, match="--ext-folder"):
        manager.get_extension_path("my.tools-0.0.0")
    (tmp_path / "my.tools").mkdir()
    kit_arguments.apply(["--ext-folder", str(tmp_path)])
    assert manager.get_extension_path("my.tools-0.0.0") == str(tmp_path / "my.tools")


@pytest.fixture
def root(stage, tmp_path):
    (tmp_path / "Isaac" / "Props").mkdir(parents=True)
    (tmp_path / "Isaac" / "Props" / "b.usd").write_bytes(b"12345")
    (tmp_path / "Isaac" / "Props" / "a").mkdir()
    assets.set_assets_root(tmp_path)
    yield tmp_path
    assets.set_assets_root(None)


def test_folders_and_files_are_listed_read_and_written(root):
    for url in (str(root / "Isaac/Props"), "/Isaac/Props", "omniverse://server/NVIDIA/../Isaac/Props/"):
        result, entries = client.list(url)
        assert result is client.Result.OK
        assert [each.relative_path for each in entries] == ["a", "b.usd"]
        assert [bool(each.flags & client.ItemFlags.CAN_HAVE_CHILDREN) for each in entries] == [True, False]
        assert entries[1].size == 5
    assert client.list("/Isaac/Missing") == (client.Result.ERROR_NOT_FOUND, ())
    assert client.stat("https://nowhere.example/x.usd") == (client.Result.ERROR_CONNECTION, None)
    result, _, content = asyncio.run(client.read_file_async("/Isaac/Props/b.usd"))
    assert (result, bytes(content)) == (client.Result.OK, b"12345")
    copied = str(root / "new" / "c.usd")
    assert client.copy("/Isaac/Props/b.usd", copied) is client.Result.OK
    assert client.copy("/Isaac/Props/b.usd", copied) is client.Result.ERROR_ALREADY_EXISTS
    assert client.write_file(f"file://{copied}", b"6") is client.Result.OK
    assert Path(copied).read_bytes() == b"6"
    assert client.delete(copied) is client.Result.OK
    assert client.stat(copied)[0] is client.Result.ERROR_NOT_FOUND
    with pytest.raises(Unsupported, match="not on this machine"):
        client.write_file("omniverse://server/x.txt", b"")


@pytest.mark.parametrize(("up", "unit"), [("Z", 1.0), ("Y", 0.01)])
def test_the_perspective_camera_sees_the_origin_from_five_meters(up, unit):
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, up)
    UsdGeom.SetStageMetersPerUnit(stage, unit)
    viewport_cameras.author(stage)
    matrix = UsdGeom.Xformable(stage.GetPrimAtPath(PERSPECTIVE)).ComputeLocalToWorldTransform(Usd.TimeCode.Default())
    assert Gf.IsClose(matrix.ExtractTranslation() * unit, Gf.Vec3d(5), 1e-9)
    assert Gf.IsClose(matrix.TransformDir((0, 0, -1)), Gf.Vec3d(-1, -1, -1).GetNormalized(), 1e-9)
    axis = Gf.Vec3d(0, 0, 1) if up == "Z" else Gf.Vec3d(0, 1, 0)
    assert abs(Gf.Dot(matrix.TransformDir((1, 0, 0)), axis)) < 1e-9
    assert Gf.Dot(matrix.TransformDir((0, 1, 0)), axis) > 0
    for path, direction in (("/OmniverseKit_Top", axis),):
        matrix = UsdGeom.Xformable(stage.GetPrimAtPath(path)).ComputeLocalToWorldTransform(Usd.TimeCode.Default())
        assert Gf.IsClose(matrix.TransformDir((0, 0, -1)), -direction, 1e-9)
    assert not stage.GetRootLayer().rootPrims


def test_the_perspective_camera_is_where_the_file_says():
    stage = Usd.Stage.CreateInMemory()
    view = {"Perspective": {"position": Gf.Vec3d(1, 2, 3), "target": Gf.Vec3d(1, 9, 3)}}
    UsdGeom.SetStageUpAxis(stage, "Z")
    stage.GetRootLayer().customLayerData = {"cameraSettings": view}
    viewport_cameras.author(stage)
    matrix = UsdGeom.Xformable(stage.GetPrimAtPath(PERSPECTIVE)).ComputeLocalToWorldTransform(Usd.TimeCode.Default())
    assert Gf.IsClose(matrix.ExtractTranslation(), Gf.Vec3d(1, 2, 3), 1e-9)
    assert Gf.IsClose(matrix.TransformDir((0, 0, -1)), Gf.Vec3d(0, 1, 0), 1e-9)


def test_a_render_product_shows_the_viewport_and_no_file_holds_its_cameras(stage, tmp_path):
    stage_context.show_viewport()
    product = rep.create.render_product(PERSPECTIVE, (64, 64))
    rep.create.sphere(semantics=[("class", "ball")], scale=2)
    mask = rep.annotators.get("semantic_segmentation", init_params={"colorize": False})
    mask.attach(product)
    rep.orchestrator.step()
    rows, columns = np.nonzero(mask.get_data()["data"] > 1)
    assert (rows.mean(), columns.mean()) == (pytest.approx(31.5, abs=1), pytest.approx(31.5, abs=1))
    saved = Sdf.Layer.FindOrOpen(str(stage_context.save_stage(tmp_path / "saved.usda")))
    assert saved.GetPrimAtPath(PERSPECTIVE)
    assert not saved.GetPrimAtPath("/OmniverseKit_Top")
    get_context().new_stage()
    assert get_context().get_stage().GetPrimAtPath("/OmniverseKit_Front")


@pytest.mark.parametrize("arc", ["Reference", "Payload"])
def test_references_in_other_units_are_scaled_once(stage, tmp_path, arc):
    source = Usd.Stage.CreateNew(str(tmp_path / "cm.usda"))
    UsdGeom.SetStageMetersPerUnit(source, 0.01)
    UsdGeom.SetStageUpAxis(source, "Y")
    UsdGeom.Cube.Define(source, "/root/box").CreateSizeAttr(100.0)
    source.SetDefaultPrim(source.GetPrimAtPath("/root"))
    tall = UsdGeom.Cube(source.GetPrimAtPath("/root/box"))
    tall.AddScaleOp().Set((1, 3, 1))
    source.Save()
    prim = stage.DefinePrim("/World/ref", "Xform")
    getattr(getattr(prim, f"Get{arc}s")(), f"Add{arc}")(str(tmp_path / "cm.usda"))
    for _ in range(2):
        assert get_metrics_assembler_interface().resolve_stage(get_context().get_stage_id())
        bounds = UsdGeom.BBoxCache(Usd.TimeCode.Default(), ["default"]).ComputeWorldBound(prim).ComputeAlignedRange()
        assert Gf.IsClose(bounds.GetSize(), Gf.Vec3d(1, 1, 3), 1e-5)


def test_the_context_closes_and_selects(stage):
    context = get_context()
    context.get_selection().set_selected_prim_paths(["/World"])
    assert context.get_selection().is_prim_path_selected("/World")
    before = context.get_stage_id()
    assert context.close_stage()
    assert context.get_stage_id() != before
    assert context.get_selection().get_selected_prim_paths() == []
    context.disable_save_to_recent_files()
    assert context.can_open_stage()
    assert context.can_close_stage()
    for needs_a_file in (context.reopen_stage, context.save_stage):
        with pytest.raises(Unsupported, match="no file"):
            needs_a_file()


def test_a_stage_with_a_file_is_saved_there(stage, tmp_path):
    context, file = get_context(), str(tmp_path / "scene.usda")
    context.save_as_stage(file)
    context.open_stage(file)
    for name in ("first", "second"):
        context.get_stage().DefinePrim(f"/World/{name}", "Cube")
        assert context.save_stage()
    context.reopen_stage()
    assert context.get_stage().GetPrimAtPath("/World/first")
    assert context.get_stage().GetPrimAtPath("/World/second")


def test_a_stage_in_memory_has_the_file_that_it_was_saved_as(stage, tmp_path, monkeypatch):
    context = get_context()
    monkeypatch.chdir(tmp_path)
    context.save_as_stage("scene.usda")
    monkeypatch.chdir(tmp_path.parent)
    assert (context.get_stage_url(), context.is_new_stage()) == (str(tmp_path / "scene.usda"), False)
    assert context.is_writable()
    assert context.get_stage() == stage
    stage.DefinePrim("/World/later", "Cube")
    assert context.save_stage()
    stage.DefinePrim("/World/lost", "Cube")
    context.reopen_stage()
    assert context.get_stage().GetPrimAtPath("/World/later")
    assert not context.get_stage().GetPrimAtPath("/World/lost")
    context.new_stage()
    assert context.is_new_stage()
    with pytest.raises(Unsupported, match="no file"):
        context.save_stage()


def test_files_and_folders_are_told_apart(stage, tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "file.txt").write_text("there")
    paths = [str(tmp_path), str(tmp_path / "empty"), str(tmp_path / "file.txt")]
    assert [nucleus.is_file(path) for path in paths] == [False, False, True]
    assert [asyncio.run(nucleus.is_dir_async(path)) for path in paths] == [True, False, False]
    with pytest.raises(AssetError, match=r"nothing\.txt is neither a file nor a folder: ERROR_NOT_FOUND"):
        nucleus.is_file(str(tmp_path / "nothing.txt"))


def test_steps_of_the_timeline_have_their_time_and_length(stage):
    timeline, heard = get_timeline_interface(), []
    timeline.set_time_codes_per_second(30)
    held = timeline.get_timeline_event_stream().create_subscription_to_pop(heard.append)
    dispatched = [
        get_eventdispatcher().observe_event(event_name=name, on_event=lambda event: heard.append(event["dt"]))
        for name in (GLOBAL_EVENT_CURRENT_TIME_TICKED, GLOBAL_EVENT_CURRENT_TIME_TICKED_PERMANENT)
    ]
    timeline.play()
    heard.clear()
    get_app().update()
    kinds = [event.type for event in heard if not isinstance(event, float)]
    assert kinds == [TimelineEventType.CURRENT_TIME_CHANGED, TimelineEventType.CURRENT_TIME_TICKED]
    assert [event if isinstance(event, float) else event.payload["dt"] for event in heard] == pytest.approx(
        [1 / 30] * 4
    )
    # Handlers that ask for other events of Kit's list find their names, and no event is taken for one.
    assert TimelineEventType.LOOP_MODE_CHANGED not in kinds
    del held, dispatched


def test_a_target_frame_rate_leaves_the_steps_as_they_are(stage):
    timeline = get_timeline_interface()
    timeline.set_target_framerate(1_000_000)
    assert (timeline.get_target_framerate(), timeline.get_time_codes_per_seconds()) == (1_000_000, 60)
    assert stage.GetTimeCodesPerSecond() == 60
    timeline.play()
    get_app().update()
    assert timeline.get_current_time() == pytest.approx(1 / 60)


@pytest.mark.parametrize("looping", [True, False])
def test_a_part_of_the_timeline_is_played(stage, looping):
    timeline = get_timeline_interface()
    timeline.set_time_codes_per_second(10)
    timeline.set_end_time(5)
    timeline.play(start_timecode=20, end_timecode=23, looping=looping)
    times = []
    for _ in range(4):
        times.append(timeline.get_current_time())
        get_app().update()
    assert times == pytest.approx([2.0, 2.1, 2.2, 2.0 if looping else 2.3])
    assert timeline.is_playing() == looping
    timeline.stop()
    assert (timeline.get_start_time(), timeline.get_end_time(), timeline.is_looping()) == (0, 5, True)
    timeline.play()
    get_app().update()
    assert timeline.get_current_time() == pytest.approx(0.1)
    with pytest.raises(BadValue, match="the end is to be after the start"):
        timeline.play(5, 5)


def test_streams_deliver_updates_and_the_timeline(stage):
    updates, played, messages = [], [], []
    timeline = get_timeline_interface()
    held = [
        get_app().get_update_event_stream().create_subscription_to_pop(lambda e: updates.append(e.payload["dt"])),
        timeline.get_timeline_event_stream().create_subscription_to_pop_by_type(
            int(TimelineEventType.PLAY), lambda e: played.append(e.type), name="mine"
        ),
        get_app().get_message_bus_event_stream().create_subscription_to_push_by_type(7, messages.append),
    ]
    timeline.play()
    get_app().update()
    timeline.stop()
    get_app().get_message_bus_event_stream().push(7, payload={"a": 1})
    get_app().get_message_bus_event_stream().push(8)
    assert updates == pytest.approx([1 / 60])
    assert played == [TimelineEventType.PLAY]
    assert [event.payload for event in messages] == [{"a": 1}]
    held.clear()
    get_app().update()
    assert len(updates) == 1


def test_a_folder_is_summed_up_by_extension(tmp_path):
    Image.new("RGB", (2, 2)).save(tmp_path / "a.png")
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "b.json").write_text("")
    found = get_folder_file_summary(tmp_path, recursive=True)
    assert found == {"total_files": 2, "extension_counts": {"png": 1, "json": 1}}
    found = get_folder_file_summary(tmp_path, include_file_sizes=True)
    (detail,) = found["file_details"]["png"]
    assert (detail["path"], detail["size_bytes"]) == (str(tmp_path / "a.png"), (tmp_path / "a.png").stat().st_size)


def test_the_context_computes_bounds_and_transforms_of_paths(stage):
    """A cube of side 2, scaled by 3 along x, 10 above the origin, with a child that sticks out."""
    cube = UsdGeom.Cube.Define(stage, "/World/cube")
    cube.AddTranslateOp().Set(Gf.Vec3d(0, 0, 10))
    cube.AddScaleOp().Set(Gf.Vec3f(3, 1, 1))
    UsdGeom.Cube.Define(stage, "/World/cube/child").AddTranslateOp().Set(Gf.Vec3d(0, 4, 0))
    low, high = get_context().compute_path_world_bounding_box("/World/cube")
    assert (low.x, low.y, low.z) == (-3, -1, 9)
    assert tuple(high) == (3, 5, 11)
    matrix = get_context().compute_path_world_transform("/World/cube")
    assert matrix == [3, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 10, 1]
    with pytest.raises(BadPrim, match="/World/none"):
        get_context().compute_path_world_bounding_box("/World/none")


def test_settings_tell_those_who_subscribed(stage):
    heard = []
    settings = get_settings()
    number = settings.subscribe_to_node_change_events("/my/key", lambda value, change: heard.append((value, change)))
    held = SettingChangeSubscription("/my/key", lambda value, change: heard.append(value))
    settings.set("/my/key", 1)
    settings.set("/my/other", 1)
    settings.set("/my/key", 2)
    assert heard == [(1, ChangeEventType.CREATED), 1, (2, ChangeEventType.CHANGED), 2]
    settings.unsubscribe_to_change_events(number)
    settings.unsubscribe_to_change_events(number)
    del held
    settings.set("/my/key", 3)
    assert len(heard) == 4


def test_trees_of_settings_tell_those_who_subscribed(stage):
    heard, settings = [], get_settings()
    number = settings.subscribe_to_tree_change_events(
        "/my/tree", lambda tree, item, change: heard.append((tree.get_dict(), item.path, item.get_dict(), change))
    )
    removed = []
    settings.subscribe_to_node_change_events("/my/tree/a", lambda value, change: removed.append((value, change)))
    settings.set("/my/tree/a", 1)
    settings.set("/my/trees", 1)
    settings.set("/my/tree/b/c", 2)
    settings.set("/my/tree/a", 3)
    settings.destroy_item("/my/tree/a")
    created, changed, destroyed = ChangeEventType
    assert heard == [
        ({"a": 1}, "/my/tree/a", 1, created),
        ({"a": 1, "b": {"c": 2}}, "/my/tree/b/c", 2, created),
        ({"a": 3, "b": {"c": 2}}, "/my/tree/a", 3, changed),
        ({"b": {"c": 2}}, "/my/tree/a", None, destroyed),
    ]
    assert removed == [(1, created), (3, changed), (None, destroyed)]
    settings.unsubscribe_to_change_events(number)
    settings.destroy_item("/my")
    assert len(heard) == 4


def test_parts_of_the_settings_are_items_live_or_as_copies(stage):
    settings, reader = get_settings(), dictionary.get_dictionary()
    settings.set("/my/part", {"a": 1, "b": {"c": "x"}, "list": [1.5, 2.5]})
    live, copy = settings.get_settings_dictionary("/my/part"), settings.create_dictionary_from_settings("my/part/")
    assert copy.get_dict() == live.get_dict() == settings.get("/my/part")
    assert (live["a"], live["b/c"], live.get("none", 7), "b" in live, "z" in live) == (1, "x", 7, True, False)
    assert (live.get_keys(), live.get_key_at(1), live.get_key_at(9), len(live)) == (["a", "b", "list"], "b", None, 3)
    live["a"], copy["a"] = 2, 3
    assert (settings.get("/my/part/a"), live["a"], copy["a"]) == (2, 2, 3)
    assert reader.get_dict_copy(copy) == {"a": 3, "b": {"c": "x"}, "list": [1.5, 2.5]}
    assert reader.get_as_string(reader.get_item(live, "b/c")) == reader.get(live, "b/c") == "x"
    assert reader.get_item_type(reader.get_item(live, "list")) is dictionary.ItemType.FLOAT
    assert [reader.get_item_name(live, name) for name in ("", "b")] == ["part", "b"]
    settings.destroy_item("/my/part")
    assert settings.get_settings_dictionary("/my/part") is settings.create_dictionary_from_settings("/my/part") is None
    settings.set("/my/part/a", 5)
    settings.update("/my/part", copy, "", dictionary.UpdateAction.KEEP)
    assert settings.get("/my/part") == {"a": 5, "b": {"c": "x"}, "list": [1.5, 2.5]}
    settings.update("/my/part", copy, "", dictionary.UpdateAction.OVERWRITE)
    assert settings.get("/my/part/a") == 3
    assert settings.is_accessible_as(dictionary.ItemType.INT, "/my/part/a")
    assert not settings.is_accessible_as(dictionary.ItemType.INT, "/my/part/b/c")
    settings.set_string_array("/my/part/list", ["x", 1])
    assert settings.get("/my/part/list") == ["x", "1"]
    for refused in (
        lambda: reader.create_item(None, "", dictionary.ItemType.DICTIONARY),
        lambda: settings.update("/my", copy, "", lambda *_: dictionary.UpdateAction.KEEP),
        dictionary.get_json_serializer,
    ):
        with pytest.raises(Unsupported):
            refused()
    settings.destroy_item("/my")


def test_what_is_done_before_an_update_is_in_its_picture(stage):
    """And what is done after it is not."""
    cube = rep.functional.create.cube(name="cube", semantics={"class": "cube"})
    camera = rep.functional.create.camera(position=(0, 0, 10), look_at=(0, 0, 0))
    boxes = rep.annotators.get("bounding_box_2d_tight")
    boxes.attach(rep.create.render_product(camera, (32, 32)))
    rep.orchestrator.set_capture_on_play(True)
    app, imageable = get_app(), UsdGeom.Imageable(cube)
    before = app.get_pre_update_event_stream().create_subscription_to_pop(lambda _: imageable.MakeInvisible())
    after = app.get_update_event_stream().create_subscription_to_pop(lambda _: imageable.MakeVisible())
    get_timeline_interface().play()
    app.update()
    assert len(boxes.get_data()["data"]) == 0
    before.unsubscribe()
    app.update()
    assert len(boxes.get_data()["data"]) == 1
    after.unsubscribe()
    get_timeline_interface().stop()


@pytest.mark.parametrize("as_url", [False, True])
def test_relative_paths_are_found_in_default_search_paths(tmp_path, monkeypatch, as_url):
    (tmp_path / "mine" / "models").mkdir(parents=True)
    inner = tmp_path / "mine" / "models" / "inner.usda"
    inner.write_text('#usda 1.0\n( defaultPrim = "A" )\ndef Cube "A" {\ndouble size = 7\n}\n')
    (tmp_path / "mine" / "models" / "outer.usda").write_text(
        '#usda 1.0\n( defaultPrim = "B" )\ndef Xform "B" {\ndef "A" ( references = @models/inner.usda@ ) {}\n}\n'
    )
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    folder = (tmp_path / "mine").as_uri() if as_url else str(tmp_path / "mine")
    client.add_default_search_path(folder)
    try:
        assert client.get_local_file("models/inner.usda") == (client.Result.OK, str(inner))
        assert client.get_local_file("./models/inner.usda")[0] is client.Result.ERROR_NOT_FOUND
        stage = stage_context.new_stage()
        (prim,) = rep.create.from_usd("models/outer.usda").get_output_prims()["prims"]
        assert stage.GetPrimAtPath(f"{prim.GetPath()}/Ref/A").GetAttribute("size").Get() == 7
        assets.check_missing(stage)
    finally:
        client.remove_default_search_path(folder)
    assert client.get_local_file("models/inner.usda")[0] is client.Result.ERROR_NOT_FOUND
