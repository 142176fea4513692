"""UsdLux dome lights to one lat-long environment map, `scene.Dome`.

Orientation. A dome's pole is the stage's up axis: for `DomeLight_1` because its poleAxis says so; for the older
`DomeLight`, whose schema says +Y always, because Omniverse renders it so and scripts written for it do not rotate it. A
`DomeLight` with UsdLux's own `orientToStageUpAxis` op was authored for a +Y pole and keeps it.
Longitudes are UsdLux's: with a Y pole the center of the texture lies toward +Z and a quarter to the left of it toward
+X; with a Z pole the center lies toward -Y.
"""

from typing import NamedTuple

import numpy as np
from pxr import Usd

from usdsdg import errors
from usdsdg.stage.poses.transforms import up_axis
from usdsdg_render.images import image_files
from usdsdg_render.lights.light_inputs import warn_of_ignored
from usdsdg_render.lights.light_textures import layout_of, linear_rgb, resample, to_latlong
from usdsdg_render.lights.light_values import (
    SHADOW,
    SHAPING,
    changed_inputs,
    emitted_color,
    light_number,
    light_value,
)
from usdsdg_render.lights.linking import is_linked
from usdsdg_render.scene.scene import Dome

# Rotation from the dome's own space to the frame of `scene.Dome`, where column u lies at angle 2 pi u.
POLE_FRAMES = {
    "Y": np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
    "Z": np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
}

LAYOUTS = ("latlong", "mirroredBall", "angular", "cubeMapVerticalCross")
UNIFORM = np.ones((1, 2, 3), np.float32)


class DomeLight(NamedTuple):
    """One dome light, before its texture is loaded."""

    path: str
    file: str  # "" for a uniform dome
    modified: tuple[int, int]
    color: tuple[float, float, float]  # radiance of a texel of 1 [nits]
    dome_from_world: bytes  # (3, 3) float64; bytes, so that domes can be compared
    visible: bool
    layout: str  # of the file: one of LAYOUTS or automatic
    diffuse: float
    specular: float

    @property
    def frame(self) -> np.ndarray:
        return np.frombuffer(self.dome_from_world).reshape(3, 3)


def read_dome(prim: Usd.Prim, local_to_world: np.ndarray) -> DomeLight | None:
    """Read the dome light at `prim`; None if it emits no light."""
    color = emitted_color(prim)
    if color is None or not color.any():
        return None
    frame = dome_frame(prim, local_to_world)
    if frame is None:
        errors.warn_once(f"{prim.GetPath()}: the dome's transform is NaN or scaled to zero; it is off. Correct it.")
        return None
    _warn_of_unsupported(prim)
    file = _file(prim)
    visible = prim.GetAttribute("visibleInPrimaryRay")
    return DomeLight(
        path=str(prim.GetPath()),
        file=file,
        modified=image_files.modified(file) if file else (0, 0),
        color=(float(color[0]), float(color[1]), float(color[2])),
        dome_from_world=np.ascontiguousarray(frame, np.float64).tobytes(),
        visible=not (visible and visible.Get() is False),
        layout=_layout(prim),
        diffuse=max(light_number(prim, "diffuse", 1.0), 0.0),
        specular=max(light_number(prim, "specular", 1.0), 0.0),
    )


def dome_frame(prim: Usd.Prim, local_to_world: np.ndarray) -> np.ndarray | None:
    """Return `Dome.dome_from_world` of a dome light, float64; None if its transform has no inverse."""
    rotation = _rotation(local_to_world)
    return None if rotation is None else POLE_FRAMES[_pole(prim)] @ rotation


def _layout(prim: Usd.Prim) -> str:
    layout = str(light_value(prim, "texture:format", "automatic"))
    if layout in (*LAYOUTS, "automatic"):
        return layout
    errors.warn_once(
        f"{prim.GetPath()}: texture format {layout} is none of {', '.join(LAYOUTS)}; the file is read as latlong."
    )
    return "latlong"


def _warn_of_unsupported(prim: Usd.Prim) -> None:
    """Warn of inputs that are not supported on a dome."""
    warn_of_ignored(prim)
    if light_value(prim, "shadow:enable", True) is False:
        errors.warn_once(f"{prim.GetPath()}: a dome light always casts shadows; inputs:shadow:enable is ignored.")
    if ignored := changed_inputs(prim, {**SHADOW, **SHAPING}):
        errors.warn_once(f"{prim.GetPath()}: {', '.join(ignored)} have no effect on a dome light. Remove them.")
    if is_linked(prim):
        errors.warn_once(f"{prim.GetPath()}: a dome light reaches everything; its light and shadow links are ignored.")


def _pole(prim: Usd.Prim) -> str:
    up = up_axis(prim.GetStage())
    if prim.GetTypeName() == "DomeLight_1":
        pole = str(prim.GetAttribute("poleAxis").Get())
        return pole if pole in POLE_FRAMES else up
    if prim.HasAttribute("xformOp:rotateX:orientToStageUpAxis"):
        return "Y"
    return up


def _rotation(local_to_world: np.ndarray) -> np.ndarray | None:
    """Return the (3, 3) rotation from world directions (columns) to the prim's space, without scale and shear."""
    linear = local_to_world[:3, :3]
    if not np.isfinite(linear).all():
        return None
    u, scale, v = np.linalg.svd(linear)
    # Row vectors: world = local @ linear, so local = linear @ world for a rotation.
    return u @ v if scale[2] > 1e-9 * scale[0] else None


def _file(prim: Usd.Prim) -> str:
    for name in ("inputs:texture:file", "texture:file"):
        attribute = prim.GetAttribute(name)
        authored, file = image_files.asset_file(attribute) if attribute else ("", "")
        if authored and not file:
            errors.warn_once(
                f"{prim.GetPath()}: {name} names {authored}, which does not exist; the dome is uniform. "
                f"Correct the path."
            )
        if authored:
            return file
    return ""


class DomeBuilder:
    """Combines dome lights to one; caches decoded textures, so that rotating or dimming a dome is cheap."""

    # Size of the cache of decoded textures, for scripts that randomize among a few domes [bytes].
    KEPT_BYTES = 1 << 29

    def __init__(self) -> None:
        self._textures: dict[tuple[str, tuple[int, int], str], np.ndarray] = {}

    def build(self, domes: list[DomeLight]) -> Dome | None:
        """Sum all domes in the frame of the first one; None if there are none."""
        if not domes:
            return None
        first = domes[0]
        for name in ("visible", "diffuse", "specular"):
            if len({getattr(dome, name) for dome in domes}) > 1:
                errors.warn_once(
                    f"{first.path}: dome lights are added up before anything sees them, but they differ in "
                    f"{'visibleInPrimaryRay' if name == 'visible' else 'inputs:' + name}; the largest is used for all. "
                    f"Give them the same."
                )
        return Dome(
            texture=self._texture(first) if len(domes) == 1 else self._sum(domes),
            dome_from_world=first.frame.astype(np.float32),
            visible=any(dome.visible for dome in domes),
            diffuse=max(dome.diffuse for dome in domes),
            specular=max(dome.specular for dome in domes),
            color=first.color if len(domes) == 1 else (1.0, 1.0, 1.0),
        )

    def _sum(self, domes: list[DomeLight]) -> np.ndarray:
        """Sum the radiance of several domes, (H, W, 3) [nits], in the frame of the first one."""
        textures = [self._texture(dome) for dome in domes]
        height = max(texture.shape[0] for texture in textures)
        width = max(texture.shape[1] for texture in textures)
        first = domes[0]
        radiance = np.zeros((height, width, 3), np.float32)
        for dome, texture in zip(domes, textures):
            if texture is UNIFORM:
                texture = texture[:, :1]
            elif dome.dome_from_world != first.dome_from_world or texture.shape[:2] != (height, width):
                texture = resample(texture, first.frame, dome.frame, (height, width))
            radiance += texture * np.array(dome.color, np.float32)
        return radiance

    def _texture(self, dome: DomeLight) -> np.ndarray:
        """Load the (H, W, 3) linear texture; UNIFORM for a dome without one."""
        if not dome.file:
            return UNIFORM
        key = (dome.file, dome.modified, dome.layout)
        if key not in self._textures:
            try:
                texture = linear_rgb(image_files.read_rgb(dome.file))
                texture = to_latlong(texture, layout_of(texture) if dome.layout == "automatic" else dome.layout)
            except errors.AssetUnreadable as error:
                errors.warn_once(f"{dome.path}: the dome texture cannot be read ({error}); the dome is uniform.")
                texture = UNIFORM
            size = texture.nbytes + sum(kept.nbytes for kept in self._textures.values())
            while self._textures and size > self.KEPT_BYTES:
                size -= self._textures.pop(next(iter(self._textures))).nbytes
            self._textures[key] = texture
        return self._textures[key]
