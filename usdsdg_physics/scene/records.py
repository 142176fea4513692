"""Plain frozen records of a scene in SI units (m, kg, s, rad): bodies, colliders, shapes, materials, joints.

Quaternions are (x, y, z, w); a pose is seven numbers x, y, z, qx, qy, qz, qw. A body's frame is its prim's frame
without the scale: origin and directions are the prim's, lengths are meters.
"""

from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np

Vec3 = tuple[float, float, float]
Quat = tuple[float, float, float, float]
CombineMode = Literal["average", "min", "multiply", "max"]
COMBINE_MODES: tuple[CombineMode, ...] = get_args(CombineMode)  # of two, the later one counts
ShapeKind = Literal["box", "sphere", "capsule", "cylinder", "cone", "plane", "hull", "mesh"]
SHAPE_KINDS: tuple[ShapeKind, ...] = get_args(ShapeKind)

STATIC = ""  # `Collider.body` of a static collider, and the world at an end of a joint
# A weld holds the two halves of a body through which a loop is cut; see `usdsdg_physics.scene.loop_cuts`.
JointKind = Literal["fixed", "revolute", "prismatic", "ball", "d6", "distance", "weld"]


@dataclass(frozen=True)
class Solid:
    """Triangles of a convex hull or mesh before any scale, in the stage units of the mesh.

    `volume`, `centroid` and `covariance` (integral of p pᵀ over the volume about the origin) belong to the closed
    surface, or to the round shape that a hull stands for, so that mass properties follow any linear map without another
    pass over the triangles.
    """

    key: str  # digest of the triangles; equal keys mean equal solids
    vertices: np.ndarray = field(compare=False, repr=False)  # (V, 3) float32
    triangles: np.ndarray = field(compare=False, repr=False)  # (F, 3) int32, outward
    volume: float = field(compare=False)
    centroid: np.ndarray = field(compare=False, repr=False)  # (3,)
    covariance: np.ndarray = field(compare=False, repr=False)  # (3, 3)


@dataclass(frozen=True)
class Shape:
    """Collision geometry, around its own origin; capsule, cylinder and cone stand along +Z."""

    kind: ShapeKind
    # box: half extents. sphere: radius, 0, 0. capsule, cylinder, cone: radius, half height, 0 (a capsule's without
    # its caps). hull, mesh: scale of `solid`, negative on one axis to mirror. plane: 0, 0, 0 (unbounded, normal +Z).
    size: Vec3
    position: Vec3 = (0.0, 0.0, 0.0)  # in the body's frame, or in the world of a static collider
    rotation: Quat = (0.0, 0.0, 0.0, 1.0)
    solid: Solid | None = None


@dataclass(frozen=True)
class Material:
    """A physics material; `path` is empty for PhysX's defaults."""

    path: str = ""
    friction: float = 0.5  # of surfaces that slide
    restitution: float = 0.0
    density: float = 0.0  # kg/m³; 0 for none
    static_friction: float = 0.5  # of surfaces that do not
    friction_mode: CombineMode = "average"
    restitution_mode: CombineMode = "average"


@dataclass(frozen=True)
class MassSpec:
    """The attributes of a MassAPI; zeros and None mean "compute it"."""

    mass: float = 0.0  # kg
    density: float = 0.0  # kg/m³
    center_of_mass: Vec3 | None = None  # m, body frame
    diagonal_inertia: Vec3 | None = None  # kg m²
    principal_axes: Quat = (0.0, 0.0, 0.0, 1.0)
    has_axes: bool = False  # whether the principal axes are authored


@dataclass(frozen=True)
class SurfaceVelocity:
    """The velocity of a body's surface relative to the body, as a conveyor belt has it."""

    linear: Vec3  # m/s
    angular: Vec3  # rad/s, about the body's origin
    local: bool = True  # in the body's frame, else in the world


@dataclass(frozen=True)
class Force:
    """A force and a torque that act on a body at every step, of a prim with PhysxForceAPI."""

    path: str
    body: str
    force: Vec3  # N; m/s² of an acceleration
    torque: Vec3  # N m; rad/s² of an acceleration
    point: Vec3 | None = None  # where it acts, in the body's frame [m]; None for the center of mass
    acceleration: bool = False
    local: bool = True  # force and torque are in the body's frame, else in the world
    enabled: bool = True


@dataclass(frozen=True)
class Collider:
    """A prim with CollisionAPI."""

    path: str
    body: str  # path of the rigid body that owns it, or STATIC
    shape: Shape
    material: Material
    enabled: bool = True
    gap: float = 0.02  # contacts are generated below this distance [m]
    margin: float = 0.0  # resting distance from the surface [m]
    mass: MassSpec = MassSpec()
    trigger: bool = False  # reports what is inside, and is not solid
    parts: int = 1  # of the prim, each a collider of its own; `usdsdg.stage.physics.instances` has their names


@dataclass(frozen=True)
class Body:
    """A prim with RigidBodyAPI."""

    path: str
    pose: tuple[float, ...]  # world, 7 numbers [m]
    # Row-vector 4x4 from the prim's local space to the body's frame [m]: scale, shear and units, constant in motion.
    body_from_prim: tuple[tuple[float, ...], ...]
    velocity: Vec3 = (0.0, 0.0, 0.0)  # of the center of mass, world, m/s
    angular_velocity: Vec3 = (0.0, 0.0, 0.0)  # world, rad/s
    kinematic: bool = False
    gravity: bool = True
    linear_damping: float = 0.0  # 1/s
    angular_damping: float = 0.05  # 1/s
    max_velocity: float = float("inf")  # m/s
    max_angular_velocity: float = 100.0  # rad/s
    max_depenetration_velocity: float = 3.0  # m/s
    sleep_threshold: float = 5e-5  # kinetic energy per mass below which it may come to rest, m²/s²
    starts_asleep: bool = False
    mass: MassSpec = MassSpec()
    # Bits 1, 2, 4: the world's x, y, z, along which it does not move, and about which it does not turn.
    locked_position: int = 0
    locked_rotation: int = 0
    surface: SurfaceVelocity | None = None
    continuous: bool = False  # whether it shall pass through nothing, however fast it is
    # No prim with RigidBodyAPI, but a collider that time samples move.
    is_collider: bool = False
    is_articulation_root: bool = False  # has ArticulationRootAPI, so that it is the base of its articulation
    # Kinematic only because a joint of it cannot be simulated.
    held: bool = False


@dataclass(frozen=True)
class Drive:
    """What pulls an axis of a joint to a position and velocity: a damped spring."""

    stiffness: float  # N/m or N m/rad; 1/s² of an acceleration drive
    damping: float  # N s/m or N m s/rad; 1/s of an acceleration drive
    target: float  # m or rad
    target_velocity: float  # m/s or rad/s
    max_force: float = float("inf")  # N or N m, of acceleration drives too
    acceleration: bool = False  # whether its strength is per mass or inertia that it moves


@dataclass(frozen=True)
class Axis:
    """A direction in which a joint moves: along it, or around it."""

    name: str  # "transX" ... "rotZ"
    angular: bool
    direction: Vec3  # in the joint's frame
    lower: float = float("-inf")  # m or rad
    upper: float = float("inf")
    drive: Drive | None = None
    armature: float = 0.0  # kg or kg m²
    static_friction: float = 0.0  # N or N m
    friction: float = 0.0  # friction per load, the sum of force [N] and torque [N m] that the joint transmits
    damping: float = 0.0  # N s/m or N m s/rad
    max_velocity: float = float("inf")  # m/s or rad/s
    position: float | None = None  # where it starts, m or rad; None: where the bodies are
    velocity: float | None = None
    instance: str = ""  # the name that its drive and its state have in their schemas
    has_state: bool = False  # whether positions and velocities are shown on the stage


@dataclass(frozen=True)
class Mimic:
    """An axis follows another: position = offset + gearing times the position of the joint `leader`."""

    leader: str  # path of a joint with one axis
    gearing: float
    offset: float | None  # m or rad; None where both stay in gear as they stand at the start


@dataclass(frozen=True)
class Joint:
    """A joint between two bodies, or a body and the world. Its frames coincide where its axes are at zero."""

    path: str
    kind: JointKind
    body0: str  # path of a rigid body, or STATIC
    body1: str
    frame0: tuple[float, ...]  # 7 numbers in the frame of body 0, or the world [m]
    frame1: tuple[float, ...]
    axes: tuple[Axis, ...] = ()  # the linear ones first; none of a ball joint, which has no limits and drives
    in_articulation: bool = True  # if there is one: physics:excludeFromArticulation is not set
    # Whether it is one of an articulation: as in PhysX, it does not break, and a base that it fixes to the world stays.
    articulated: bool = False
    break_force: float = float("inf")  # N
    break_torque: float = float("inf")  # N m
    mimic: Mimic | None = None
    distance: tuple[float, float] = (0.0, float("inf"))  # between the frames of a distance joint [m]
    # Stiffness [N/m] and damping [N s/m] with which a distance joint keeps its distance; None where it is rigid.
    spring: tuple[float, float] | None = None

    @property
    def breaks(self) -> bool:
        """Whether a force or torque breaks it."""
        return not self.articulated and min(self.break_force, self.break_torque) < float("inf")


@dataclass(frozen=True)
class ContactReportSpec:
    """Which contacts of a prim with PhysxContactReportAPI are reported."""

    path: str
    threshold: float  # N that the contacts of a pair push with at least; 0 for all that touch
    partners: tuple[str, ...] = ()  # paths that the other collider is at or below; empty for any


@dataclass(frozen=True)
class Scene:
    """All that is simulated; bodies and colliders by prim path, in the order of the stage."""

    bodies: dict[str, Body]
    colliders: dict[str, Collider]
    gravity: Vec3  # m/s²
    scene_path: str  # of the PhysicsScene prim, "" for none
    bounce_threshold: float = 0.5  # m/s of approach from which contacts bounce
    default_material: Material = Material()  # of colliders to which no physics material is bound
    # Pairs of colliders that never collide, each in path order.
    filtered: frozenset[tuple[str, str]] = frozenset()
    forces: dict[str, Force] = field(default_factory=dict)  # by prim path
    joints: dict[str, Joint] = field(default_factory=dict)  # those that are simulated, by prim path
    instancers: tuple[str, ...] = ()  # PointInstancers; what they make is named as in `usdsdg.stage.physics.instances`
    prototypes: tuple[str, ...] = ()  # paths at and below which prims are parts of prototypes
    animated: tuple[str, ...] = ()  # kinematic bodies that follow time samples
    reports: dict[str, ContactReportSpec] = field(default_factory=dict)  # by prim path
    # Whether joints, collision groups or filtered pairs relate its prims, so that no part of it can be read alone.
    has_relations: bool = False
    relations: tuple[str, ...] = ()  # paths of the prims that do, and of roots of articulations
    halves: dict[str, str] = field(default_factory=dict)  # bodies that were cut off others, by path: whose they are

    @property
    def is_empty(self) -> bool:
        """Whether nothing is simulated or collides, so that no edit but one of a physics schema matters."""
        parts = (self.bodies, self.colliders, self.forces, self.joints, self.instancers, self.prototypes, self.reports)
        return not any(parts)
