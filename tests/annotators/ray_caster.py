"""A slow renderer that shares nothing with ours: cubes and spheres of a stage, one ray per pixel center, in NumPy."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from pxr import Gf, Usd, UsdGeom

from tests.stage.geometry.counted_masks import counted_masks
from usdsdg.annotators import Frame, LabeledPrimReader
from usdsdg.session import render_products
from usdsdg.stage.cameras.camera_view import CameraView, read_camera
from usdsdg.stage.geometry.pixel_masks import MASK_WORD, WORD_PIXELS, PixelMasks
from usdsdg.stage.semantics.labels import add_labels
from usdsdg_render.settings import LIGHT_AOVS

CAMERA = "/World/Camera"
PRODUCT = "/Render/HydraTextures/Replicator"


def new_stage() -> Usd.Stage:
    """Meters, Z up, a camera 10 m above the origin that looks straight down."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.Xform.Define(stage, "/World")
    camera = UsdGeom.Camera.Define(stage, CAMERA)
    camera.CreateFocalLengthAttr(24.0)
    camera.CreateHorizontalApertureAttr(20.955)
    camera.CreateClippingRangeAttr(Gf.Vec2f(0.1, 100.0))
    place(camera.GetPrim(), translate=(0, 0, 10))
    return stage


def place(prim: Usd.Prim, *, translate=(0, 0, 0), rotate=(0, 0, 0), scale=(1, 1, 1)) -> None:
    """Translate, rotateXYZ [degrees], scale."""
    xform = UsdGeom.Xformable(prim)
    xform.ClearXformOpOrder()
    xform.AddTranslateOp(opSuffix="", precision=UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(*map(float, translate)))
    xform.AddRotateXYZOp().Set(Gf.Vec3f(*map(float, rotate)))
    xform.AddScaleOp().Set(Gf.Vec3f(*map(float, scale)))


def add_cube(stage: Usd.Stage, path: str, label: str | None = None, *, size: float = 1.0, **pose) -> Usd.Prim:
    cube = UsdGeom.Cube.Define(stage, path)
    cube.CreateSizeAttr(size)
    return _finish(cube.GetPrim(), label, pose)


def add_sphere(stage: Usd.Stage, path: str, label: str | None = None, *, radius: float = 0.5, **pose) -> Usd.Prim:
    sphere = UsdGeom.Sphere.Define(stage, path)
    sphere.CreateRadiusAttr(radius)
    return _finish(sphere.GetPrim(), label, pose)


def _finish(prim: Usd.Prim, label: str | None, pose: dict) -> Usd.Prim:
    place(prim, **pose)
    if label:
        add_labels(prim, {"class": [label]})
    return prim


class RayCaster:
    """The renderer's interface, as far as labels go, for a stage of cubes and spheres."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        shapes = [prim for prim in stage.Traverse() if prim.GetTypeName() in ("Cube", "Sphere")]
        self.gprims = tuple(str(p.GetPath()) for p in shapes if UsdGeom.Imageable(p).ComputeVisibility() != "invisible")

    def labels(self, view: CameraView) -> dict[str, np.ndarray]:
        """All AOVs."""
        origins, directions = rays(view)
        distance = np.full(len(origins), np.inf)
        instance = np.full(len(origins), -1, np.int32)
        normals = np.zeros((len(origins), 3))
        for index in range(len(self.gprims)):
            hit, normal = self._intersect(index, origins, directions, view.clipping_range)
            closer = hit < distance
            distance[closer], instance[closer], normals[closer] = hit[closer], index, normal[closer]
        position = origins + np.where(np.isfinite(distance), distance, 0)[:, None] * directions
        shape = (view.height, view.width)
        in_camera = position @ view.world_to_camera[:3, :3] + view.world_to_camera[3, :3]
        seen = np.isfinite(distance)
        local = np.zeros_like(position)
        for index in range(len(self.gprims)):
            own = instance == index
            local[own] = transformed(position[own], np.linalg.inv(self.matrix(index)))
        color = np.full((len(origins), 4), 255, np.uint8)
        color[:, :3] = np.where(seen[:, None], normals * 100 + 128, 60)
        return {
            "instance": instance.reshape(shape),
            "triangle": np.where(seen, 0, -1).astype(np.int32).reshape(shape),
            "barycentrics": np.where(seen[:, None], (1.0, 0.0, 0.0), 0).astype(np.float32).reshape(*shape, 3),
            "local_position": local.astype(np.float32).reshape(*shape, 3),
            "distance_to_camera": np.where(seen, distance * view.meters_per_unit, np.inf).astype("f4").reshape(shape),
            "distance_to_image_plane": np.where(seen, -in_camera[:, 2] * view.meters_per_unit, np.inf)
            .astype("f4")
            .reshape(shape),
            "normals": normals.astype(np.float32).reshape(*shape, 3),
            "position": np.where(seen[:, None], position, 0).astype(np.float32).reshape(*shape, 3),
            "bump_normals": (-normals).astype(np.float32).reshape(*shape, 3),
            "albedo": np.full((*shape, 3), 0.5, np.float32),
            "diffuse": np.where(seen[:, None], (0.5, 0.25, 0.125), 0).astype(np.float32).reshape(*shape, 3),
            "specular": np.where(seen[:, None], (0.04, 0.5, 1.0), 0).astype(np.float32).reshape(*shape, 3),
            "roughness": np.where(seen, 0.3, 0).astype(np.float32).reshape(shape),
            "emission": np.where(seen[:, None], (0.0, 20.0, 1e6), 0).astype(np.float32).reshape(*shape, 3),
            "transmission": np.where(seen[:, None], (0.0, 0.25, 1.0), 0).astype(np.float32).reshape(*shape, 3),
            "ambient_occlusion": np.where(seen, 0.75, 1).astype(np.float32).reshape(shape),
            **{part: np.full((*shape, 3), 10.0 * k, np.float32) for k, part in enumerate(LIGHT_AOVS)},
            "motion_vectors": np.zeros((*shape, 2), np.float32),
            "LdrColor": color.reshape(*shape, 4),
            "HdrColor": (color.astype(np.float32) / 255).astype(np.float16).reshape(*shape, 4),
        }

    def pixel_masks(
        self, view: CameraView, groups: Sequence[Sequence[int]], *, instance: np.ndarray | None = None
    ) -> PixelMasks:
        """What each group covers alone, and where one of it comes first."""
        origins, directions = rays(view)
        everything = range(len(self.gprims))
        hits = [self._intersect(index, origins, directions, view.clipping_range)[0] for index in everything]
        seen = RayCaster.labels(self, view)["instance"] if instance is None else instance
        words = []
        for row, group in enumerate(groups):
            covered = np.isfinite([hits[index] for index in group]).any(0)
            for y, x in np.argwhere(covered.reshape(view.height, view.width)):
                shown = int(seen[y, x]) in group
                words.append((row, y, x // WORD_PIXELS, 1 << int(x % WORD_PIXELS), shown << int(x % WORD_PIXELS)))
        single = np.array(words, MASK_WORD)
        keys, first = np.unique(single[["group", "row", "word"]], return_index=True)
        merged = single[first]
        for name in ("covered", "visible"):
            merged[name] = np.bitwise_or.reduceat(single[name], first) if len(keys) else merged[name]
        return counted_masks((view.height, view.width), len(groups), merged)

    def _intersect(self, index: int, origins, directions, clipping) -> tuple[np.ndarray, np.ndarray]:
        """Distances along the (unit) rays, inf for a miss, and world normals."""
        prim = self._stage.GetPrimAtPath(self.gprims[index])
        to_local = np.linalg.inv(self.matrix(index))
        o, d = origins @ to_local[:3, :3] + to_local[3, :3], directions @ to_local[:3, :3]
        with np.errstate(all="ignore"):
            if prim.GetTypeName() == "Cube":
                t, normal = _hit_cube(o, d, UsdGeom.Cube(prim).GetSizeAttr().Get() / 2)
            else:
                t, normal = _hit_sphere(o, d, UsdGeom.Sphere(prim).GetRadiusAttr().Get())
        normal = normal @ to_local[:3, :3].T
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        return np.where(t > 0, t, np.inf), normal

    def matrix(self, index: int) -> np.ndarray:
        """Local to world of a gprim, (4, 4)."""
        return np.array(UsdGeom.XformCache().GetLocalToWorldTransform(self._stage.GetPrimAtPath(self.gprims[index])))

    def first_hits(self, origins, directions, first, last) -> tuple[np.ndarray, np.ndarray]:
        """As `SceneQueries.first_hits`."""
        hits = [self._intersect(index, origins, directions, None)[0] for index in range(len(self.gprims))]
        hits = np.stack([*hits, np.full(len(origins), np.inf)])
        hits[(hits < first) | (hits > last)] = np.inf
        distance = hits.min(axis=0)
        return distance, np.where(np.isfinite(distance), hits.argmin(axis=0), -1)


class SlowScene:
    """The queries that annotators make to a scene, answered by the ray caster; for pinholes."""

    def __init__(self, caster: RayCaster, view: CameraView, time: Usd.TimeCode) -> None:
        self._caster, self._view, self.time = caster, view, time

    @property
    def gprim_to_world(self) -> np.ndarray:
        return np.array([self._caster.matrix(k) for k in range(len(self._caster.gprims))]).reshape(-1, 4, 4)

    def coverage_around(self, groups: Sequence[Sequence[int]]) -> np.ndarray:
        wide = self._view.widened()
        assert wide is not None
        left, top = wide.margin
        found = np.full((len(groups), 5), -1)
        origins, directions = rays(wide)
        for row, group in zip(found, groups, strict=True):
            hits = [self._caster._intersect(each, origins, directions, None)[0] for each in group]
            covered = np.isfinite(hits).any(axis=0).reshape(wide.height, wide.width)
            covered[top : top + self._view.height, left : left + self._view.width] = False
            y, x = np.nonzero(covered)
            row[0] = len(x)
            if len(x):
                row[1:] = x.min() - left, y.min() - top, x.max() - left, y.max() - top
        return found

    def first_hits(self, *arguments) -> tuple[np.ndarray, np.ndarray]:
        return self._caster.first_hits(*arguments)

    def follow(self, view: CameraView, captures: int) -> tuple[np.ndarray, np.ndarray]:
        aovs = self._caster.labels(self._view)
        shape, seen = aovs["instance"].shape, aovs["instance"] >= 0
        pixels, states = np.full((*shape, 2), np.nan, np.float32), np.zeros(shape, np.uint8)
        points = aovs["position"][seen].astype(float)
        if captures or not len(points):
            return pixels, states
        pixels[seen], _ = view.project(points)
        origins = np.broadcast_to(view.local_to_world[3, :3], points.shape)
        distance = np.linalg.norm(points - origins, axis=1)
        near = np.zeros(len(points))
        hit = self.first_hits(origins, (points - origins) / distance[:, None], near, distance * 0.999)[1]
        with np.errstate(invalid="ignore"):
            inside = ((pixels[seen] >= 0) & (pixels[seen] < (view.width, view.height))).all(axis=1)
        states[seen] = np.where(inside, np.where(hit < 0, 2, 1), 0)
        return pixels, states


def transformed(points: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Points (N, 3) times a matrix (4, 4) for row vectors."""
    return points @ matrix[:3, :3] + matrix[3, :3]


def rays(view: CameraView) -> tuple[np.ndarray, np.ndarray]:
    """Origins and unit directions in the world through the center of every pixel, row by row."""
    v, u = np.mgrid[0 : view.height, 0 : view.width]
    focal = (view.width - 2 * view.margin[0]) * view.focal_length / view.horizontal_aperture
    x, y = (u + 0.5 - view.width / 2) / focal, (view.height / 2 - v - 0.5) / focal
    in_camera = np.stack([x, y, -np.ones_like(x)], axis=-1).reshape(-1, 3)
    directions = in_camera @ view.local_to_world[:3, :3]
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return np.broadcast_to(view.local_to_world[3, :3], directions.shape), directions


def _hit_cube(o, d, half):
    near, far = (-half - o) / d, (half - o) / d
    low, high = np.minimum(near, far), np.maximum(near, far)
    enter, leave = low.max(axis=1), high.min(axis=1)
    axis = low.argmax(axis=1)
    normal = np.zeros_like(d)
    normal[np.arange(len(d)), axis] = -np.sign(d[np.arange(len(d)), axis])
    return np.where((enter <= leave) & (enter > 0), enter, np.inf), normal


def _hit_sphere(o, d, radius):
    a, b, c = (d * d).sum(1), (o * d).sum(1), (o * o).sum(1) - radius**2
    root = b * b - a * c
    t = np.where(root >= 0, (-b - np.sqrt(np.maximum(root, 0))) / a, np.inf)
    return t, o + np.where(np.isfinite(t), t, 0)[:, None] * d


def known(*products: str) -> list[str]:
    """Render products at these paths, to be attached to."""
    return [render_products.add(render_products.HydraTexture(path, CAMERA, (1, 1))).path for path in products]


def make_frame(
    stage: Usd.Stage,
    resolution: tuple[int, int] = (128, 96),
    *,
    camera: str = CAMERA,
    filters: Iterable[str | None] = (),
    reader: LabeledPrimReader | None = None,
    product: str = PRODUCT,
    index: int = 0,
) -> Frame:
    """A frame of the stage as it is, with every AOV."""
    view = read_camera(stage, camera, resolution)
    caster = RayCaster(stage)
    labeled_prims = (reader or LabeledPrimReader(stage)).read(caster.gprims, filters)
    return Frame(
        index=index,
        view=view,
        render_product=product,
        aovs=caster.labels(view),
        gprims=caster.gprims,
        labeled_prims=labeled_prims,
        amodal_masks=caster.pixel_masks(view, labeled_prims.groups),
        reference_time=(index, 60),
        scene=SlowScene(caster, view, Usd.TimeCode(index / 60 * stage.GetTimeCodesPerSecond())),
    )
