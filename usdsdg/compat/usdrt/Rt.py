"""`usdrt.Rt`: poses of prims as Fabric has them, read from and written to the USD stage."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pxr import Gf, Usd, UsdGeom

from usdsdg.session.timeline import stage_time
from usdsdg.stage.poses.rotations import decompose
from usdsdg.stage.poses.transforms import as_array, inverse_of_parent, local_to_world
from usdsdg.stage.poses.xform_ops import author_pose, gf_quat


class PoseAttribute:
    """An attribute of Fabric that holds (a part of) a pose: read and set on the stage."""

    def __init__(self, read: Callable[[], Any], write: Callable[[Any], None]) -> None:
        self._read, self._write = read, write

    def Get(self, time: object = None) -> Any:
        """Return the value now; Fabric has no other time."""
        return self._read()

    def Set(self, value: Any, time: object = None) -> bool:
        self._write(value)
        return True

    def IsValid(self) -> bool:
        return True

    def HasValue(self) -> bool:
        return True


def _maker(get: Callable[[Any], PoseAttribute]) -> Callable[..., PoseAttribute]:
    """Return a method that makes an attribute: it is there already, and gets the value if there is one."""

    def create(self: Xformable, value: Any = None) -> PoseAttribute:
        attribute = get(self)
        if value is not None:
            attribute.Set(value)
        return attribute

    return create


class Xformable:
    """The pose of a prim, in the world and relative to its parent."""

    def __init__(self, prim: Usd.Prim | Usd.SchemaBase) -> None:
        self._prim: Usd.Prim = prim.GetPrim()

    def __bool__(self) -> bool:
        return bool(self._prim) and self._prim.IsA(UsdGeom.Xformable)

    def GetPrim(self) -> Usd.Prim:
        return self._prim

    def GetPath(self) -> Any:
        return self._prim.GetPath()

    # --- in the world ---
    def GetWorldPositionAttr(self) -> PoseAttribute:
        """As Vec3d."""
        return PoseAttribute(lambda: Gf.Vec3d(self._world().ExtractTranslation()), lambda v: self._place(translate=v))

    def GetWorldOrientationAttr(self) -> PoseAttribute:
        """As Quatf."""
        return PoseAttribute(lambda: _quat(self._world()), lambda v: self._place(orient=v))

    def GetWorldScaleAttr(self) -> PoseAttribute:
        """As Vec3f."""
        return PoseAttribute(lambda: _scale(self._world()), lambda v: self._place(scale=v))

    def GetFabricHierarchyWorldMatrixAttr(self) -> PoseAttribute:
        """As Matrix4d."""
        return PoseAttribute(self._world, self._set_world)

    # --- relative to the parent ---
    def GetLocalMatrixAttr(self) -> PoseAttribute:
        """As Matrix4d."""
        return PoseAttribute(self._local, self._set_local)

    GetFabricHierarchyLocalMatrixAttr = GetLocalMatrixAttr

    # --- what makes the attributes in Fabric: they are there already ---
    def _there(self) -> bool:
        """Return True: USD has the pose."""
        return True

    HasWorldXform = HasLocalXform = SetWorldXformFromUsd = SetLocalXformFromUsd = _there
    HasFabricHierarchyWorldMatrixAttr = HasFabricHierarchyLocalMatrixAttr = _there

    CreateWorldPositionAttr, CreateWorldOrientationAttr = _maker(GetWorldPositionAttr), _maker(GetWorldOrientationAttr)
    CreateWorldScaleAttr, CreateLocalMatrixAttr = _maker(GetWorldScaleAttr), _maker(GetLocalMatrixAttr)
    CreateFabricHierarchyWorldMatrixAttr = _maker(GetFabricHierarchyWorldMatrixAttr)
    CreateFabricHierarchyLocalMatrixAttr = _maker(GetLocalMatrixAttr)

    # --- on the stage ---
    def _now(self) -> Usd.TimeCode:
        return stage_time(self._prim.GetStage())

    def _world(self) -> Gf.Matrix4d:
        return local_to_world(self._prim, self._now())

    def _local(self) -> Gf.Matrix4d:
        return UsdGeom.Xformable(self._prim).GetLocalTransformation(self._now())

    def _set_world(self, matrix: Gf.Matrix4d) -> None:
        self._set_local(Gf.Matrix4d(matrix) * inverse_of_parent(self._prim, self._now()))

    def _set_local(self, matrix: Gf.Matrix4d) -> None:
        pose = decompose(as_array(Gf.Matrix4d(matrix)))
        author_pose(self._prim, translate=pose.translate, orient=gf_quat(pose.rotation), scale=pose.scale)

    def _place(self, translate: Any = None, orient: Any = None, scale: Any = None) -> None:
        """Set a part of the pose in the world, and keep the others."""
        world = self._world()
        size = Gf.Vec3d(scale) if scale is not None else Gf.Vec3d(_scale(world))
        turn = Gf.Rotation(Gf.Quatd(orient if orient is not None else _quat(world)))
        matrix = Gf.Matrix4d().SetScale(size) * Gf.Matrix4d().SetRotate(turn)
        matrix.SetTranslateOnly(Gf.Vec3d(translate) if translate is not None else world.ExtractTranslation())
        self._set_world(matrix)


def _quat(matrix: Gf.Matrix4d) -> Gf.Quatf:
    return Gf.Quatf(gf_quat(decompose(as_array(matrix)).rotation))


def _scale(matrix: Gf.Matrix4d) -> Gf.Vec3f:
    return Gf.Vec3f(*(float(each) for each in decompose(as_array(matrix)).scale))
