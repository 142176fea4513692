"""Stand-ins, made by code, for assets of Isaac Sim that scripts name and a folder of free assets lacks."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from usdsdg.image_files import radiance_hdr
from usdsdg.stage import schemas
from usdsdg.stage.schemas import physx

Vector = tuple[float, float, float]


def overlay(assets_root: Path, folder: Path) -> Path:
    """Fill `folder` with links to the files of `assets_root` and with stand-ins for what it lacks; return it."""
    schemas.register()
    for file in (path for path in assets_root.rglob("*") if path.is_file()):
        link = folder / file.relative_to(assets_root)
        link.parent.mkdir(parents=True, exist_ok=True)
        if not link.exists():
            link.symlink_to(file)
    for name, make in STAND_INS.items():
        file = folder / name
        if not file.exists():
            file.parent.mkdir(parents=True, exist_ok=True)
            make(file)
    return folder


def _arm(file: Path) -> None:
    """Seven revolute joints, a hand and two prismatic fingers, with the prim names of the Franka Panda."""
    stage = _stage(file, "/panda")
    UsdPhysics.ArticulationRootAPI.Apply(stage.GetDefaultPrim())
    heights = (0.0, 0.333, 0.333, 0.649, 0.649, 1.033, 1.033, 1.12)
    for index, height in enumerate(heights):
        _link(stage, f"/panda/panda_link{index}", (0, 0, height), (0.1, 0.1, 0.08))
    _joint(stage, "/panda/root_joint", UsdPhysics.FixedJoint, "", "/panda/panda_link0")
    for index, axis in enumerate("ZYZYZYZ"):
        below, above = f"/panda/panda_link{index}", f"/panda/panda_link{index + 1}"
        joint = _joint(
            stage, f"{below}/panda_joint{index + 1}", UsdPhysics.RevoluteJoint, below, above,
            (0, 0, heights[index + 1] - heights[index]),
        )  # fmt: skip
        _move(joint, axis, (-160, 160), stiffness=400)
    hand, last = "/panda/panda_hand", "/panda/panda_link7"
    _link(stage, hand, (0, 0, 1.2), (0.04, 0.2, 0.06))
    _joint(stage, f"{last}/panda_hand_joint", UsdPhysics.FixedJoint, last, hand, (0, 0, 0.08))
    for number, name, side, limits in ((1, "left", 1, (-0.04, 0.0)), (2, "right", -1, (0.0, 0.04))):
        finger = f"/panda/panda_{name}finger"
        _link(stage, finger, (0, 0.04 * side, 1.26), (0.02, 0.015, 0.05))
        joint = _joint(
            stage, f"{hand}/panda_finger_joint{number}", UsdPhysics.PrismaticJoint, hand, finger, (0, 0.04 * side, 0.06)
        )
        _move(joint, "Y", limits, stiffness=1000)
    stage.Save()


def _gripper(file: Path) -> None:
    """A gripper of six linked revolute joints, with the prim names of the xArm gripper, and a can to grasp."""
    stage = _stage(file, "/World")
    UsdPhysics.Scene.Define(stage, "/World/PhysicsScene")
    stage.DefinePrim("/World/Light", "DomeLight").GetAttribute("inputs:intensity").Set(800.0)
    gripper = "/World/Grippers/xarm_gripper"
    root = _posed(stage, gripper, (0, 0, 1))
    UsdPhysics.ArticulationRootAPI.Apply(root)
    base, joints = f"{gripper}/base", f"{gripper}/joints"
    _link(stage, base, (0, 0, 0), (0.06, 0.06, 0.05))
    _joint(stage, f"{gripper}/root_joint", UsdPhysics.FixedJoint, "", base)
    stage.DefinePrim(joints, "Scope")
    for name, side in (("left", 1), ("right", -1)):
        outer, finger, inner = (f"{gripper}/{name}_{part}" for part in ("outer_knuckle", "finger", "inner_knuckle"))
        _link(stage, outer, (0, 0.035 * side, 0.06), (0.02, 0.01, 0.02))
        _link(stage, finger, (0, 0.07 * side, 0.11), (0.02, 0.012, 0.05), (0, -0.02 * side, 0.04))
        _link(stage, inner, (0, 0.02 * side, 0.075), (0.02, 0.008, 0.02))
        driven = "drive_joint" if side > 0 else "right_outer_knuckle_joint"
        for joint, before, after, position in (
            (driven, base, outer, (0, 0.035 * side, 0.06)),
            (f"{name}_finger_joint", outer, finger, (0, 0.035 * side, 0.05)),
            (f"{name}_inner_knuckle_joint", base, inner, (0, 0.02 * side, 0.075)),
        ):
            prim = _joint(stage, f"{joints}/{joint}", UsdPhysics.RevoluteJoint, before, after, position)
            drives = joint == "drive_joint"
            _move(prim, "X", (0, 50) if drives else (-50, 50), stiffness=20 if drives else None)
    for name, gearing in (
        ("left_finger", 1), ("left_inner_knuckle", -1), ("right_outer_knuckle", 1), ("right_finger", -1),
        ("right_inner_knuckle", 1),
    ):  # fmt: skip
        mimic = physx.PhysxMimicJointAPI.Apply(stage.GetPrimAtPath(f"{joints}/{name}_joint"), "rotX")
        mimic.CreateGearingAttr(float(gearing))
        mimic.CreateReferenceJointRel().SetTargets([f"{joints}/drive_joint"])
    _can(stage, "/World/Objects/_05_tomato_soup_can")
    stage.Save()


def _can(stage: Usd.Stage, path: str) -> None:
    """A closed cylinder as a mesh, 6.8 cm wide and 10.2 cm high, without gravity."""
    can = _posed(stage, path, (0.3, 0, 0.3))
    count = 48
    turns = [2 * math.pi * index / count for index in range(count)]
    rings = [
        Gf.Vec3f(0.034 * math.cos(turn), 0.034 * math.sin(turn), height) for height in (-0.051, 0.051) for turn in turns
    ]
    sides = [(index, (index + 1) % count, count + (index + 1) % count, count + index) for index in range(count)]
    mesh = UsdGeom.Mesh.Define(stage, f"{path}/can")
    mesh.CreatePointsAttr(rings)
    mesh.CreateFaceVertexCountsAttr([4] * count + [count, count])
    mesh.CreateFaceVertexIndicesAttr(
        [corner for side in sides for corner in side] + [*range(count - 1, -1, -1), *range(count, 2 * count)]
    )
    mesh.CreateSubdivisionSchemeAttr("none")
    UsdPhysics.RigidBodyAPI.Apply(can)
    UsdPhysics.CollisionAPI.Apply(mesh.GetPrim())
    UsdPhysics.MeshCollisionAPI.Apply(mesh.GetPrim()).CreateApproximationAttr("convexHull")
    physx.PhysxRigidBodyAPI.Apply(can).CreateDisableGravityAttr(True)


def _robot(file: Path) -> None:
    """A box on two wheels, for scripts that only look at a robot."""
    stage = _stage(file, "/carter")
    chassis = UsdGeom.Cube.Define(stage, "/carter/chassis")
    chassis.CreateSizeAttr(1.0)
    chassis.AddTranslateOp().Set(Gf.Vec3d(0, 0, 0.4))
    chassis.AddScaleOp().Set(Gf.Vec3f(0.7, 0.5, 0.4))
    chassis.CreateDisplayColorAttr([Gf.Vec3f(0.1, 0.6, 0.1)])
    for name, side in (("left", 1), ("right", -1)):
        wheel = UsdGeom.Cylinder.Define(stage, f"/carter/wheel_{name}")
        wheel.CreateAxisAttr("Y")
        wheel.CreateRadiusAttr(0.25)
        wheel.CreateHeightAttr(0.08)
        wheel.AddTranslateOp().Set(Gf.Vec3d(0, 0.3 * side, 0.25))
    stage.Save()


def _material(color: Vector) -> Callable[[Path], None]:
    def make(file: Path) -> None:
        red, green, blue = color
        file.write_text(
            "mdl 1.4;\n"
            "import ::OmniPBR::OmniPBR;\n"
            f"export material {file.stem}(*) = OmniPBR::OmniPBR(\n"
            f"    diffuse_color_constant: color({red}, {green}, {blue}),\n"
            "    reflection_roughness_constant: 0.8f\n"
            ");\n"
        )

    return make


def _sky(file: Path) -> None:
    """A blue sky that is brightest above the horizon, over brown ground, as a panorama of 64x32 pixels."""
    pixels = np.empty((32, 64, 3), np.float32)
    pixels[:16] = np.linspace((0.3, 0.5, 1.0), (0.9, 0.9, 1.0), 16)[:, None]
    pixels[16:] = 0.3, 0.2, 0.1
    file.write_bytes(radiance_hdr.encode(pixels))


def _texture(color: Vector) -> Callable[[Path], None]:
    def make(file: Path) -> None:
        """Stripes of 8 pixels in a color and a darker one."""
        bright = (np.arange(64) // 8 % 2).astype(bool)[None, :, None]
        pixels = np.where(bright, color, np.array(color) / 2) * np.ones((64, 1, 1)) * 255
        Image.fromarray(pixels.astype(np.uint8)).save(file)

    return make


def _grid(file: Path) -> None:
    """A ground plane of 100 m with a light, seen from nearby."""
    stage = _stage(file, "/World")
    view = {"position": Gf.Vec3d(3.0), "target": Gf.Vec3d(0.0)}
    stage.GetRootLayer().customLayerData = {"cameraSettings": {"Perspective": view}}
    stage.DefinePrim("/World/Light", "DomeLight").GetAttribute("inputs:intensity").Set(1000.0)
    ground = UsdGeom.Mesh.Define(stage, "/World/GroundPlane/mesh")
    ground.CreatePointsAttr([(-50, -50, 0), (50, -50, 0), (50, 50, 0), (-50, 50, 0)])
    ground.CreateFaceVertexCountsAttr([4])
    ground.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    stage.Save()


def _stage(file: Path, root: str) -> Usd.Stage:
    stage = Usd.Stage.CreateNew(str(file))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetDefaultPrim(stage.DefinePrim(root, "Xform"))
    return stage


def _posed(stage: Usd.Stage, path: str, position: Vector) -> Usd.Prim:
    xform = UsdGeom.Xform.Define(stage, path)
    xform.AddTranslateOp().Set(Gf.Vec3d(*position))
    xform.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Quatd(1))
    return xform.GetPrim()


def _link(stage: Usd.Stage, path: str, position: Vector, size: Vector, center: Vector = (0, 0, 0)) -> None:
    UsdPhysics.RigidBodyAPI.Apply(_posed(stage, path, position))
    box = UsdGeom.Cube.Define(stage, f"{path}/geometry")
    box.CreateSizeAttr(1.0)
    box.AddTranslateOp().Set(Gf.Vec3d(*center))
    box.AddScaleOp().Set(Gf.Vec3f(*size))
    UsdPhysics.CollisionAPI.Apply(box.GetPrim())


def _joint(
    stage: Usd.Stage, path: str, kind: type[UsdPhysics.Joint], body0: str, body1: str, position: Vector = (0, 0, 0)
) -> Usd.Prim:
    joint = kind.Define(stage, path)
    if body0:
        joint.CreateBody0Rel().SetTargets([Sdf.Path(body0)])
    joint.CreateBody1Rel().SetTargets([Sdf.Path(body1)])
    joint.CreateLocalPos0Attr(Gf.Vec3f(*position))
    return joint.GetPrim()


def _move(prim: Usd.Prim, axis: str, limits: tuple[float, float], stiffness: float | None) -> None:
    """Give a joint its axis, its limits [degrees or stage units] and, with a stiffness, a position drive."""
    angular = prim.IsA(UsdPhysics.RevoluteJoint)
    joint = UsdPhysics.RevoluteJoint(prim) if angular else UsdPhysics.PrismaticJoint(prim)
    joint.CreateAxisAttr(axis)
    joint.CreateLowerLimitAttr(limits[0])
    joint.CreateUpperLimitAttr(limits[1])
    instance = "angular" if angular else "linear"
    physx.JointStateAPI.Apply(prim, instance)
    if stiffness is not None:
        drive = UsdPhysics.DriveAPI.Apply(prim, instance)
        drive.CreateStiffnessAttr(stiffness)
        drive.CreateDampingAttr(stiffness / 5)
        drive.CreateTargetPositionAttr(0.0)


WAREHOUSE = "Isaac/Environments/Simple_Warehouse/Materials"
PATTERNS = "Isaac/Materials/Textures/Patterns"
STAND_INS: dict[str, Callable[[Path], None]] = {
    "Isaac/Environments/Grid/default_environment.usd": _grid,
    "Isaac/Robots/FrankaRobotics/FrankaPanda/franka.usd": _arm,
    "Isaac/Samples/Replicator/Stage/sdg_grasping_xarm.usd": _gripper,
    "Isaac/Robots/NVIDIA/Carter/carter_v1_physx_lidar.usd": _robot,
    f"{WAREHOUSE}/MI_PaperNotes_01.mdl": _material((0.85, 0.82, 0.7)),
    f"{WAREHOUSE}/MI_CardBoxB_05.mdl": _material((0.55, 0.4, 0.25)),
    f"{PATTERNS}/nv_brick_grey.jpg": _texture((0.6, 0.6, 0.6)),
    f"{PATTERNS}/nv_bamboo_desktop.jpg": _texture((0.8, 0.7, 0.4)),
    **{
        f"NVIDIA/Assets/Skies/{name}_4k.hdr": _sky
        for name in (
            "Clear/evening_road_01", "Clear/mealie_road", "Clear/noon_grass", "Clear/qwantani",
            "Cloudy/champagne_castle_1", "Cloudy/kloofendal_48d_partly_cloudy", "Evening/evening_road_01",
            "Night/kloppenheim_02", "Night/moonlit_golf",
        )
    },
}  # fmt: skip
