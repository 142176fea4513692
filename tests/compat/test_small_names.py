"""Small names of Isaac Sim and Kit that scripts use beside others, and remedies for those that are elsewhere."""

import asyncio
import importlib
import os
import tempfile

import numpy as np
import pytest
from pxr import Gf, Sdf

import usdsdg as rep
from usdsdg.app.app import get_app
from usdsdg.compat import carb, finder
from usdsdg.compat.coverage.verdicts import MISSING, verdict
from usdsdg.compat.isaacsim.core.utils import numpy as many
from usdsdg.compat.isaacsim.core.utils.numpy import maths, tensor, transformations
from usdsdg.compat.omni import client
from usdsdg.compat.omni.kit import app as kit_app
from usdsdg.compat.omni.kit import commands
from usdsdg.compat.omni.kit.viewport.utility import get_active_viewport
from usdsdg.compat.omni.syntheticdata import helpers
from usdsdg.errors import ArgumentError, Unsupported

POSITIONS = np.array([[1.0, 2.0, 3.0], [0.0, -1.0, 0.5]])
ORIENTATIONS = np.array([[0.5, 0.5, -0.5, 0.5], [0.8, 0.0, 0.6, 0.0]])


# Arrays


def test_poses_in_parents_are_those_in_the_world_again():
    turned = Gf.Matrix4d().SetTransform(Gf.Rotation(Gf.Vec3d(1, 2, 3), 50), Gf.Vec3d(4, 5, 6))
    parents = np.array([turned, Gf.Matrix4d(1)])  # of USD, for row vectors
    local = transformations.get_local_from_world(parents, POSITIONS, ORIENTATIONS)
    for number, parent in enumerate((turned, Gf.Matrix4d(1))):
        assert np.allclose(parent.Transform(Gf.Vec3d(*map(float, local[0][number]))), POSITIONS[number], atol=1e-5)
    positions, orientations = transformations.get_world_from_local(parents, *local)
    assert positions == pytest.approx(POSITIONS, abs=1e-5)
    assert np.abs(np.sum(orientations * ORIENTATIONS, axis=1)) == pytest.approx([1, 1], abs=1e-5)
    assert transformations.get_pose(POSITIONS, ORIENTATIONS)[1].tolist() == [0.0, -1.0, 0.5, 0.8, 0.0, 0.6, 0.0]
    assert transformations.tf_matrices_from_poses(POSITIONS, ORIENTATIONS)[:, :3, 3] == pytest.approx(POSITIONS)


def test_poses_are_assigned_with_the_scalar_of_quaternions_last():
    """Those of other indices stay, and what is None."""
    before = POSITIONS.copy(), ORIENTATIONS.copy()
    poses = many.assign_pose(POSITIONS, ORIENTATIONS, [[7.0, 8.0, 9.0]], [[1.0, 0.0, 0.0, 0.0]], [1])
    assert poses.tolist() == [[1.0, 2.0, 3.0, 0.5, -0.5, 0.5, 0.5], [7.0, 8.0, 9.0, 0.0, 0.0, 0.0, 1.0]]
    assert many.assign_pose(POSITIONS, ORIENTATIONS, None, None, [0, 1]).tolist() == (
        many.get_pose(POSITIONS, many.wxyz2xyzw(ORIENTATIONS)).tolist()
    )
    assert (before[0] == POSITIONS).all()
    assert (before[1] == ORIENTATIONS).all()


def test_the_schema_of_behaviors_can_be_asked_for(stage):
    from usdsdg.stage.schemas.scripting_schema import OmniScriptingAPI

    prim = stage.DefinePrim("/World/behaving")
    assert not prim.HasAPI(OmniScriptingAPI)
    commands.execute("ApplyScriptingAPICommand", paths=["/World/behaving"])
    assert prim.HasAPI(OmniScriptingAPI)
    assert prim.GetAppliedSchemas() == ["OmniScriptingAPI"]
    commands.execute("RemoveScriptingAPICommand", paths=["/World/behaving"])
    assert not prim.HasAPI(OmniScriptingAPI)
    api = OmniScriptingAPI.Apply(prim)
    api.CreateOmniScriptingScriptsAttr().Set([Sdf.AssetPath("behavior.py")])
    assert [each.path for each in prim.GetAttribute("omni:scripting:scripts").Get()] == ["behavior.py"]


def test_arrays_are_made_joined_and_filled():
    assert tensor.create_zeros_tensor([2, 3], "int32").dtype == np.int32
    assert tensor.create_tensor_from_list([1, 0], "bool").tolist() == [True, False]
    assert tensor.convert([1, 2]).dtype == np.float32
    assert tensor.resolve_indices(None, 3).tolist() == [0, 1, 2]
    assert tensor.tensor_cat([np.zeros((2, 1)), np.ones((2, 2))]).shape == (2, 3)
    assert tensor.tensor_stack([np.zeros(2), np.ones(2)]).shape == (2, 2)
    assert tensor.pad([1, 2], (1, 0), value=7).tolist() == [7, 1, 2]
    assert tensor.assign(5, np.zeros((2, 2)), [np.array([0]), np.array([1])]).tolist() == [[0, 5], [0, 0]]
    copied = tensor.clone_tensor(POSITIONS)
    copied[:] = 0
    assert POSITIONS.any()
    with pytest.raises(ArgumentError, match="dtype is 'float16'; expected one of float32"):
        tensor.as_type([1], "float16")
    assert maths.matmul(maths.inverse(np.diag([2.0, 4.0])), np.eye(2)).tolist() == [[0.5, 0], [0, 0.25]]
    assert maths.transpose_2d([[1, 2], [3, 4]]).tolist() == [[1, 3], [2, 4]]
    assert maths.sin(0.0) + maths.cos(0.0) == 1.0


# Kit


@pytest.mark.parametrize(
    ("url", "parts"),
    [
        (
            "omniverse://me@host:3009/a/b.usd?checkpoint=1#x",
            ("omniverse", "me", "host", "3009", "/a/b.usd", "checkpoint=1", "x"),
        ),
        ("omniverse://host/a", ("omniverse", None, "host", None, "/a", None, None)),
        ("file:///a/b", ("file", None, None, None, "/a/b", None, None)),
        ("/a/b.usd", (None, None, None, None, "/a/b.usd", None, None)),
        ("C:/a/b.usd", (None, None, None, None, "C:/a/b.usd", None, None)),
    ],
)
def test_urls_are_taken_apart_and_put_together(url, parts):
    broken = client.break_url(url)
    assert (broken.scheme, broken.user, broken.host, broken.port, broken.path, broken.query, broken.fragment) == parts
    assert client.make_url(*parts) == url


def test_the_end_of_the_application_is_told_once(stage):
    asyncio.set_event_loop(None)
    told = []
    held = get_app().get_shutdown_event_stream().create_subscription_to_pop(lambda event: told.append(event.type))
    get_app().open_loop()
    get_app().post_quit()
    get_app().close()
    assert told == [kit_app.POST_QUIT_EVENT_TYPE, kit_app.PRE_SHUTDOWN_EVENT_TYPE]
    assert held


def test_commands_are_listed_by_name():
    class PaintCommand(commands.Command): ...

    commands.register(PaintCommand)
    found = commands.get_commands()
    assert found["Paint"] == found["PaintCommand"] == {__name__: PaintCommand}
    assert {"ChangeProperty", "ChangePropertyCommand"} <= found.keys()
    commands.unregister(PaintCommand)
    assert "Paint" not in commands.get_commands()


# Projection


def test_directions_of_pixels_lead_to_the_points_that_they_show(stage):
    camera = rep.create.camera(position=(3, 2, 1), look_at=(0, 0.5, 0))
    viewport = get_active_viewport()
    viewport.camera_path, viewport.resolution = f"{camera.prims[0]}/Camera", (64, 48)
    params = helpers.get_view_params(viewport)
    points = np.array([[0.3, 0.2, -0.1], [-0.4, 1.0, 0.2]])
    pixels = helpers.world_to_image(points, viewport)[:, :2] * (64, 48)
    origin, directions = helpers.image_to_world(pixels, params)
    assert origin == pytest.approx([3, 2, 1])
    expected = (points - origin) / np.linalg.norm(points - origin, axis=1, keepdims=True)
    assert directions == pytest.approx(expected, abs=1e-6)
    with pytest.raises(Unsupported, match="image_to_world: the camera has the projection 'fisheyePolynomial'"):
        helpers.image_to_world(pixels, {**params, "projection_type": "fisheyePolynomial"})


@pytest.mark.parametrize(
    ("name", "remedy"),
    [
        ("pxr.PhysxSchema.PhysxPhysicsGearJoint", "stage.DefinePrim(path, 'PhysxPhysicsGearJoint')"),
        ("omni.syntheticdata.helpers.reduce_occlusion", "annotators.get('occlusion')"),
    ],
)
def test_names_that_are_elsewhere_have_a_remedy(name, remedy):
    found = verdict(name)
    assert found.state == MISSING
    assert remedy in found.why
    finder.install()
    module, _, attribute = name.rpartition(".")
    with pytest.raises(AttributeError) as raised:
        getattr(importlib.import_module(module), attribute)
    assert "elsewhere" in str(raised.value) or "DefinePrim" in str(raised.value)


@pytest.mark.parametrize(("vector", "number"), [(carb.Int3, int), (carb.Uint3, int), (carb.Float3, float)])
def test_vectors_of_carb_have_numbers_of_their_type(vector, number):
    made = vector(1, 2.0, 3)
    assert (made.x, made.y, made.z) == (1, 2, 3)
    assert all(type(each) is number for each in (*made, *vector()))
    assert vector((4, 5, 6)) == (4, 5, 6)
    with pytest.raises(TypeError, match="takes 3 numbers"):
        vector(1, 2)


@pytest.mark.parametrize("vector", [carb.Uint2, carb.Uint3, carb.Uint4])
def test_unsigned_vectors_of_carb_refuse_negative_numbers(vector):
    numbers = list(range(vector.size))
    assert vector(numbers) == tuple(numbers)
    with pytest.raises(TypeError, match="not below 0"):
        vector(*numbers[:-1], -1)


# Tokens


def test_tokens_stand_for_folders_and_for_what_a_script_sets(tmp_path, monkeypatch):
    tokens = carb.tokens.get_tokens_interface()
    assert tokens.resolve("${temp}/pictures") == f"{tempfile.gettempdir()}/pictures"
    assert os.path.isdir(tokens.resolve("${kit}"))
    tokens.set_value("mine", "a")
    tokens.set_initial_value("mine", "b")
    assert tokens.resolve("x/${mine}/${mine}$y") == "x/a/a$y"
    assert tokens.remove_token("mine")
    assert not tokens.exists("mine")
    (tmp_path / "omni/mine").mkdir(parents=True)
    (tmp_path / "omni/mine/__init__.py").touch()
    monkeypatch.syspath_prepend(tmp_path)
    assert tokens.resolve("${omni.mine}/data") == f"{tmp_path}/data"  # a script's own extension


def test_tokens_that_there_are_none_of_are_named():
    tokens = carb.tokens.get_tokens_interface()
    assert tokens.resolve("${none}/a", carb.tokens.RESOLVE_FLAG_LEAVE_TOKEN_IF_NOT_FOUND) == "${none}/a"
    with pytest.warns(UserWarning, match=r"no token \$\{none\}"):
        assert tokens.resolve("${none}/a") == "/a"
