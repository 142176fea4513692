"""What worlds cannot draw is refused in one line, which names it and the script line."""

import pytest
from pxr import UsdGeom

import usdsdg as rep
from tests.worlds import scenes
from usdsdg.capture.worlds import WorldTap
from usdsdg.errors import ArgumentError, OutOfDeviceMemory, Unsupported
from usdsdg.session import session
from usdsdg.session.devices.memory import device_memory
from usdsdg.session.timeline import get_timeline

uniform = rep.distribution.uniform


@pytest.fixture(autouse=True)
def _session():
    yield
    session.restart()


def rocks():
    """The path of a PointInstancer of three cubes."""
    made = UsdGeom.PointInstancer.Define(rep.get_stage(), "/World/Rocks")
    made.CreatePrototypesRel().SetTargets([rep.get_stage().DefinePrim("/World/Rocks/cube", "Cube").GetPath()])
    made.CreateProtoIndicesAttr([0, 0, 0])
    made.CreatePositionsAttr([(0, 0, 0), (2, 0, 0), (0, 2, 0)])
    return [str(made.GetPath())]


def scene(edit, trigger=None):
    """A scene of which a node under a trigger changes a cube, a lamp or the camera."""

    def build():
        rep.create.light(light_type="dome", intensity=500)
        parts = {
            "cube": rep.create.cube(semantics=[("class", "cube")]),
            "lamp": rep.create.light(light_type="sphere", intensity=500, position=(0, 0, 5)),
            "floor": rep.create.plane(scale=4),
            "ball": rep.create.sphere(position=(0, 0, 3)),
            "camera": rep.create.camera(position=(5, 0, 2), look_at=(0, 0, 0)),
            "rocks": rocks(),
        }
        with (trigger or rep.trigger.on_frame)():
            edit(parts)
        return parts["camera"]

    return build


CASES = {
    "OgnWriteMaterial": lambda p: rep.randomizer.materials(rep.create.material_omnipbr(count=2), input_prims=p["cube"]),
    "sampled voxels": lambda p: rep.randomizer.scatter_3d(p["ball"], viz_sampled_voxels=True, input_prims=p["cube"]),
    "the point instances of /World/Rocks cannot be scattered": lambda p: rep.randomizer.scatter_2d(
        p["floor"], input_prims=p["rocks"]
    ),
    "pivot": lambda p: rep.modify.pose(position=uniform((0, 0, 0), (1, 1, 1)), pivot=(0, 0, -1), input_prims=p["cube"]),
    "size": lambda p: rep.modify.pose(size=uniform(1, 2), input_prims=p["cube"]),
    "focalLength": lambda p: rep.modify.attribute("focalLength", uniform(10, 30), input_prims=p["camera"]),
    "inputs:radius": lambda p: rep.modify.attribute("radius", uniform(0.1, 1), input_prims=p["lamp"]),
    "scale of a light": lambda p: rep.modify.pose(scale=uniform(0.1, 1), input_prims=p["lamp"]),
    "the point instances of /World/Rocks cannot be posed": lambda p: rep.modify.pose(
        position=uniform((0, 0, 0), (1, 1, 1)), input_prims=p["rocks"]
    ),
    "the point instances of /World/Rocks cannot be rotated": lambda p: rep.randomizer.rotation(input_prims=p["rocks"]),
    "velocities of the point instances": lambda p: rep.modify.attribute(
        "velocities", uniform((0, 0, 0), (1, 1, 1)), input_prims=p["rocks"]
    ),
    "size of the point instances or prototypes": lambda p: rep.modify.attribute(
        "size", uniform(0.1, 1), input_prims=p["rocks"]
    ),
    "labels that are drawn": lambda p: rep.modify.semantics(
        rep.distribution.choice([[("class", "ball")], [("class", "egg")]]), mode="replace", input_prims=p["cube"]
    ),
    "look_at": lambda p: rep.modify.pose(look_at=rep.distribution.choice(p["cube"]), input_prims=p["camera"]),
}


@pytest.mark.parametrize("what", CASES)
def test_what_cannot_differ_is_named_with_its_line(what):
    with pytest.raises(Unsupported, match=r"^worlds: Ogn\w+ \(made at test_refusals.py:\d+\)") as refused:
        scenes.worlds_of(scene(CASES[what]), 2, names=("distance_to_camera",))
    assert what in str(refused.value)
    assert "\n" not in str(refused.value)
    assert str(refused.value).endswith("Leave it out, or run without worlds.")


def test_labels_of_some_frames_are_refused_and_those_of_every_frame_are_not():
    label = lambda p: rep.modify.semantics([("class", "egg")], mode="replace", input_prims=p["cube"])  # noqa: E731
    with pytest.raises(Unsupported, match="labels that are not written in every frame cannot differ"):
        scenes.worlds_of(scene(label, lambda: rep.trigger.on_frame(interval=2)), 3)
    [batch] = scenes.worlds_of(scene(label), 2, names=("bounding_box_2d_tight",))
    assert [batch.classes[number] for number in batch.class_ids.tolist()] == [{"class": "egg"}]


def test_triggers_of_time_and_a_playing_timeline_are_refused():
    moves = lambda p: rep.modify.pose(rotation_z=uniform(0, 90), input_prims=p["cube"])  # noqa: E731
    with pytest.raises(Unsupported, match=r"OgnOnTime \(made at test_refusals.py:\d+\) does not fire by frames"):
        scenes.worlds_of(scene(moves, rep.trigger.on_time), 2)
    scenes.begin(scene(moves))
    session.current().worlds = WorldTap(2, ["rgb"], print)
    get_timeline().play()
    with pytest.raises(Unsupported, match="the timeline plays, and worlds have no physics"):
        rep.orchestrator.step()


def test_bodies_that_a_run_would_let_fall_are_refused():
    scenes.begin(scene(lambda p: rep.modify.pose(rotation_z=uniform(0, 90), input_prims=p["cube"])))
    rep.physics.rigid_body(input_prims=rep.get.prims(path_pattern="/Replicator/Cube_Xform$"))
    session.current().worlds = WorldTap(2, ["rgb"], lambda *_: None)
    with pytest.raises(Unsupported, match="Cube_Xform is a rigid body, so frames follow from each other"):
        rep.orchestrator.step()
    rep.orchestrator.set_capture_on_play(False)
    rep.orchestrator.step()


def test_annotators_and_numbers_of_worlds_are_checked():
    with pytest.raises(ArgumentError, match="cannot show skeleton_data; they can show rgb"):
        WorldTap(2, ["rgb", "skeleton_data"], print)
    with pytest.raises(ArgumentError, match="0 is no number of worlds"):
        WorldTap(0, ["rgb"], print)


def test_memory_that_is_used_up_is_one_line_with_the_remedy():
    with pytest.raises(OutOfDeviceMemory) as raised, device_memory():
        raise RuntimeError("Failed to allocate 2500000000 bytes on device 'cpu'")
    assert str(raised.value) == (
        "the memory of cpu does not suffice for 2.50 GB more. Render fewer worlds (--worlds) or cameras at a time, or "
        "smaller images."
    )
    with pytest.raises(RuntimeError, match="another failure"), device_memory():
        raise RuntimeError("another failure")


@pytest.mark.parametrize("count", [0, -1, "4", 4.0, None])
def test_what_is_no_number_of_worlds_is_said(count):
    with pytest.raises(ArgumentError, match=rf"^worlds: {count!r} is no number of worlds; expected 1 or more$"):
        WorldTap(count, ["rgb"], print)


def test_an_annotator_with_parameters_is_refused_by_its_pair():
    with pytest.raises(ArgumentError, match=r"^worlds cannot show \('rgb', {'size': 3}\); they can show rgb, "):
        WorldTap(2, [("rgb", {"size": 3})], print)  # pyright: ignore[reportArgumentType]
