"""Contact and motion sensors: weight, free fall, turning tables, and when they measure."""

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdPhysics

from usdsdg.compat.isaacsim.core.api import World
from usdsdg.compat.isaacsim.core.api.objects import DynamicCuboid
from usdsdg.compat.isaacsim.sensors.physics import ContactSensor, IMUSensor, _sensor
from usdsdg.compat.omni.kit.commands import execute
from usdsdg.errors import BadPrim

BOX, DT, G = "/World/box", 1 / 60, 9.81


@pytest.fixture
def world(stage):
    World.clear_instance()
    yield World()
    World.clear_instance()


@pytest.fixture
def box(world):
    """A cube of 0.5 m and 2 kg on the ground, or where a test places it."""
    world.scene.add_ground_plane(restitution=0.0)
    return world.scene.add(DynamicCuboid(BOX, "box", position=np.array([0, 0, 0.25]), size=0.5, mass=2.0))


def run(world, steps):
    for _ in range(steps):
        world.step(render=False)


def test_a_contact_sensor_reads_the_weight(world, box):
    sensor = ContactSensor(f"{BOX}/sensor")
    sensor.add_raw_contact_data_to_frame()
    assert sensor.get_current_frame() == {"time": 0, "physics_step": 0, "contacts": []}
    world.reset()
    run(world, 30)
    frame = sensor.get_current_frame()
    assert frame["in_contact"]
    assert frame["force"] == pytest.approx(2 * G, rel=0.02)
    assert frame["number_of_contacts"] == len(frame["contacts"]) >= 3
    # Impulses are on body 0: together they carry the weight for a step.
    signs = [1 if each["body0"] == BOX else -1 for each in frame["contacts"]]
    total = sum(sign * each["impulse"] for sign, each in zip(signs, frame["contacts"]))
    assert total == pytest.approx([0, 0, 2 * G * DT], abs=0.01)
    assert all(abs(each["position"][2]) < 0.01 for each in frame["contacts"])
    assert frame["physics_step"] == pytest.approx(frame["time"] / DT, abs=0.1)
    sensor.remove_raw_contact_data_from_frame()
    assert "contacts" not in sensor.get_current_frame()


def test_thresholds_and_a_radius_filter_contacts(world, box):
    weak = ContactSensor(f"{BOX}/weak", min_threshold=50.0)
    strong = ContactSensor(f"{BOX}/strong", max_threshold=5.0)
    above = ContactSensor(f"{BOX}/above", translation=np.array([0, 0, 5.0]), radius=0.1)
    world.reset()
    run(world, 30)
    assert not weak.get_current_frame()["in_contact"]
    assert weak.get_current_frame()["force"] == 0.0
    assert strong.get_current_frame()["force"] == 5.0
    assert not above.get_current_frame()["in_contact"]
    assert (weak.get_min_threshold(), strong.get_max_threshold()) == (50.0, 5.0)
    assert above.get_radius() == pytest.approx(0.1)


def test_an_imu_reads_what_holds_it_and_nothing_in_free_fall(world, box):
    sensor = IMUSensor(f"{BOX}/imu")
    assert not sensor.get_current_frame()["is_valid"]
    world.reset()
    run(world, 30)
    frame = sensor.get_current_frame()
    assert frame["is_valid"]
    assert frame["lin_acc"] == pytest.approx([0, 0, G], abs=0.05)
    assert sensor.get_current_frame(read_gravity=False)["lin_acc"] == pytest.approx([0, 0, 0], abs=0.05)
    box.set_world_pose(position=np.array([0, 0, 10.0]))
    run(world, 5)
    assert sensor.get_current_frame()["lin_acc"] == pytest.approx([0, 0, 0], abs=0.01)
    assert sensor.get_current_frame(read_gravity=False)["lin_acc"] == pytest.approx([0, 0, -G], abs=0.01)


def test_an_imu_reads_in_its_own_axes(world, box):
    """Turned by 90 degrees about X, what is up in the world is the sensor's Y axis."""
    sensor = IMUSensor(f"{BOX}/imu", orientation=np.array([np.sqrt(0.5), np.sqrt(0.5), 0, 0]))
    world.reset()
    run(world, 30)
    frame = sensor.get_current_frame()
    assert frame["lin_acc"] == pytest.approx([0, G, 0], abs=0.05)
    assert frame["orientation"] == pytest.approx([np.sqrt(0.5), np.sqrt(0.5), 0, 0], abs=1e-3)


def test_an_imu_off_the_axis_of_a_turning_body_feels_it(world, box):
    """Centripetal acceleration: the square of the rate times the radius, toward the axis."""
    world.get_physics_context().set_gravity(0.0)
    sensor = IMUSensor(f"{BOX}/imu", translation=np.array([2.0, 0, 0]))
    world.reset()
    box.set_world_pose(position=np.array([0, 0, 10.0]))
    box.set_angular_velocity(np.array([0, 0, 1.5]))
    run(world, 20)
    frame = sensor.get_current_frame()
    rate = box.get_angular_velocity()[2]  # damped a little
    assert frame["ang_vel"] == pytest.approx([0, 0, rate], rel=1e-3)
    # The shape is scaled, and so is what is below it. Velocities differ over a step by the chord of 1.5° at its middle.
    radius = np.linalg.norm(sensor.get_world_pose()[0] - box.get_world_pose()[0])
    assert frame["lin_acc"][0] == pytest.approx(-(rate**2) * radius, rel=0.02)
    assert frame["lin_acc"][1:] == pytest.approx([0, 0], abs=0.1)


def test_an_imu_averages_over_steps(world, box):
    """A single push of one step is spread over the width of the filter."""
    world.get_physics_context().set_gravity(0.0)
    sensor = IMUSensor(f"{BOX}/imu", linear_acceleration_filter_size=4, angular_velocity_filter_size=4)
    world.reset()
    box.set_world_pose(position=np.array([0, 0, 10.0]))
    run(world, 12)
    box.set_linear_velocity(np.array([0.6, 0.0, 0.0]))
    read = []
    for _ in range(9):
        run(world, 1)
        read.append(sensor.get_current_frame()["lin_acc"][0])
    assert max(read) < 0.6 / DT / 3
    assert sum(read) * DT == pytest.approx(0.6, rel=0.02)


def test_a_sensor_with_a_period_measures_at_its_multiples(world, box):
    contact = ContactSensor(f"{BOX}/contact", frequency=10)
    imu = IMUSensor(f"{BOX}/imu", dt=0.1)
    assert (contact.get_frequency(), imu.get_dt()) == (10, pytest.approx(0.1))
    world.reset()
    times = set()
    for _ in range(40):
        run(world, 1)
        times.add((round(contact.get_current_frame()["time"], 3), round(imu.get_current_frame()["time"], 3)))
    assert all(abs(time * 10 - round(time * 10)) < 1e-3 for pair in times for time in pair)
    assert len(times) == pytest.approx(40 * DT / 0.1, abs=2)
    assert imu.get_current_frame()["lin_acc"] == pytest.approx([0, 0, G], abs=0.1)


def test_a_paused_sensor_reads_nothing_new(world, box):
    sensor = IMUSensor(f"{BOX}/imu")
    world.reset()
    run(world, 10)
    sensor.pause()
    assert sensor.is_paused()
    assert not sensor.get_current_frame()["is_valid"]
    sensor.resume()
    run(world, 2)
    assert sensor.get_current_frame()["is_valid"]


def test_readings_begin_again_after_a_reset(world, box):
    sensor = IMUSensor(f"{BOX}/imu")
    world.reset()
    run(world, 50)
    world.reset()
    run(world, 3)
    assert sensor.get_current_frame()["time"] < 10 * DT


def test_commands_and_interfaces_read_the_same(world, box):
    ok, imu = execute("IsaacSensorCreateImuSensor", path="/imu", parent=BOX, sensor_period=-1.0)
    assert ok
    _, contact = execute("IsaacSensorCreateContactSensor", path="/contact", parent=BOX, max_threshold=1000.0)
    assert [prim.GetTypeName() for prim in (imu, contact)] == ["IsaacImuSensor", "IsaacContactSensor"]
    imus, touches = _sensor.acquire_imu_sensor_interface(), _sensor.acquire_contact_sensor_interface()
    assert imus.is_imu_sensor(f"{BOX}/imu")
    assert touches.is_contact_sensor(f"{BOX}/contact")
    assert not imus.get_sensor_reading(f"{BOX}/imu").is_valid
    assert not touches.get_sensor_reading(f"{BOX}/contact").is_valid
    world.reset()
    run(world, 30)
    reading = imus.get_sensor_reading(f"{BOX}/imu", use_latest_data=True)
    assert reading.lin_acc_z == pytest.approx(G, abs=0.05)
    assert reading.orientation == pytest.approx((0, 0, 0, 1), abs=1e-3)
    assert touches.get_sensor_reading(f"{BOX}/contact").value == pytest.approx(2 * G, rel=0.02)
    raw = touches.get_contact_sensor_raw_data(f"{BOX}/contact")
    assert {touches.decode_body_name(raw["body0"][0]), touches.decode_body_name(raw["body1"][0])} >= {BOX}
    assert np.abs(raw["impulse"].sum(axis=0)) == pytest.approx([0, 0, 2 * G * DT], abs=0.01)


def test_sensors_that_are_asked_once_have_read_since_a_command_made_them(world, box):
    execute("IsaacSensorCreateContactSensor", path="/touch", parent="/World/box")
    execute("IsaacSensorCreateImuSensor", path="/imu", parent="/World/box")
    world.reset()
    for _ in range(60):
        world.step()
    assert _sensor.acquire_contact_sensor_interface().get_sensor_reading("/World/box/touch").in_contact
    assert _sensor.acquire_imu_sensor_interface().get_sensor_reading("/World/box/imu").is_valid


def test_sensors_of_the_stage_read_from_the_play_after_an_interface_was_taken(world, box, stage):
    interface = _sensor.acquire_contact_sensor_interface()
    sensor = stage.DefinePrim("/World/box/touch", "IsaacContactSensor")
    sensor.GetAttribute("threshold").Set(Gf.Vec2f(0, 1000))
    stage.DefinePrim("/World/nowhere", "IsaacContactSensor")
    world.reset()
    for _ in range(60):
        world.step()
    assert interface.get_sensor_reading("/World/box/touch").in_contact
    with pytest.raises(BadPrim, match="/World/nowhere"):
        interface.get_sensor_reading("/World/nowhere")


def test_sensors_need_a_body(world, stage):
    UsdGeom.Cube.Define(stage, "/World/still")
    with pytest.raises(BadPrim, match="/World/still is no collider"):
        ContactSensor("/World/still/sensor")
    with pytest.raises(BadPrim, match="no rigid body above"):
        IMUSensor("/World/still/imu")
    with pytest.raises(BadPrim, match="no prim at parent"):
        execute("IsaacSensorCreateImuSensor", path="/imu")
    with pytest.raises(ValueError, match="either frequency or dt"):
        IMUSensor("/World/still/imu", frequency=10, dt=0.1)


def test_a_sensor_below_a_link_measures_the_link(world, stage):
    """A collider below the body: contacts are those of the body."""
    body = UsdGeom.Xform.Define(stage, "/World/link")
    body.AddTranslateOp().Set(Gf.Vec3d(3, 0, 0.25))
    UsdPhysics.RigidBodyAPI.Apply(body.GetPrim())
    UsdPhysics.MassAPI.Apply(body.GetPrim()).CreateMassAttr(1.0)
    shape = UsdGeom.Cube.Define(stage, "/World/link/shape")
    shape.CreateSizeAttr(0.5)
    UsdPhysics.CollisionAPI.Apply(shape.GetPrim())
    world.scene.add_ground_plane()
    sensor = ContactSensor("/World/link/shape/sensor")
    world.reset()
    run(world, 60)
    assert sensor.get_current_frame()["force"] == pytest.approx(G, rel=0.02)
