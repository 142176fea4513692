"""Lights in many worlds: other brightness, color and place of the lights of one stage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pxr import Usd

from usdsdg.errors import Unsupported
from usdsdg.stage.colors import LUMINANCE
from usdsdg.stage.world_values import WorldValues
from usdsdg_render.lights.domes import dome_frame
from usdsdg_render.lights.light_inputs import read_inputs
from usdsdg_render.lights.light_rows import emission, light_areas, light_frames, light_rows, read_light
from usdsdg_render.lights.light_values import FIRST_INTENSITIES, light_number, light_value, temperature_color
from usdsdg_render.scene.scene import LIGHT, Scene
from usdsdg_render.usd.color_spaces import refuse_other_space
from usdsdg_render.usd.prim_kinds import DOME_TYPES

# Inputs that say how bright a light is, and of what color.
EMISSION = ("intensity", "exposure", "color", "enableColorTemperature", "colorTemperature")
_SCALE_TOLERANCE = 1e-6


@dataclass(frozen=True)
class LightsInWorlds:
    """Lights of worlds, as in `scene.worlds.Worlds`."""

    table: np.ndarray
    dome_color: np.ndarray
    dome_from_world: np.ndarray


def lights_in_worlds(
    scene: Scene, values: WorldValues, prims: Sequence[Usd.Prim], local_to_world: np.ndarray, meters_per_unit: float
) -> LightsInWorlds:
    """Return the lights of worlds.

    Args:
        prims: all lights and domes of the stage, in the order of the scene's.
        local_to_world: (worlds or 1, prims, 4, 4).

    Raises:
        Unsupported: a light differs in size, or in what `EMISSION` does not list; or there are several domes.
    """
    count = values.count
    rows, color, frame = [], np.zeros((count, 3)), np.tile(np.eye(3, dtype=np.float32), (count, 1, 1))
    if scene.dome is not None:
        color[:], frame[:] = scene.dome.color, scene.dome.dome_from_world
    domes = [prim for prim in prims if prim.GetTypeName() in DOME_TYPES]
    for k, prim in enumerate(prims):
        matrices = local_to_world[:, k]
        differs = len(matrices) > 1 and not (matrices == matrices[:1]).all()
        try:
            own = _values_of(prim, values)
            if prim.GetTypeName() not in DOME_TYPES:
                row = _rows(prim, own, matrices, count, differs, meters_per_unit)
                rows += [row] if row is not None else []
                continue
            if (own or differs) and len(domes) > 1:
                raise Unsupported(f"{prim.GetPath()}: of several dome lights none can differ between worlds")
            if own:
                color = emitted_colors(prim, own, count)
            if differs:
                frames = [each for matrix in matrices if (each := dome_frame(prim, matrix)) is not None]
                if len(frames) < len(matrices):
                    raise Unsupported(f"{prim.GetPath()}: in some worlds the dome's transform has no inverse")
                frame[:] = np.stack(frames)
        except Unsupported as error:
            raise values.refusal(prim.GetPath(), error) from None
    table = np.zeros((count, len(rows)), LIGHT)
    for k, row in enumerate(rows):
        table[:, k] = row
    if table.shape[1] == len(scene.lights):
        for name in ("emission_profile", "links"):
            table[name] = scene.lights[name]
    elif scene.emission_profiles or scene.light_links:
        raise Unsupported(
            "lights that are off in world 0, beside lights with profiles or links, cannot be on in others"
        )
    return LightsInWorlds(table, color, frame)


def _values_of(prim: Usd.Prim, values: WorldValues) -> dict[str, np.ndarray]:
    own = {}
    for name, column in values.of(prim.GetPath()).items():
        if name.startswith("xformOp:") or name == "visibility":
            continue
        short = name.removeprefix("inputs:")
        if short not in EMISSION:
            raise Unsupported(f"{prim.GetPath()}: {name} cannot differ between worlds; of a light these can: "
                              f"{', '.join(EMISSION)}, and its pose")  # fmt: skip
        own[short] = np.asarray(column, np.float64)
    return own


def _rows(
    prim: Usd.Prim, own: dict[str, np.ndarray], matrices: np.ndarray, count: int, differs: bool, meters_per_unit: float
) -> np.ndarray | None:
    """(worlds,) rows of a light; None if it emits nothing in all worlds."""
    if not own and not differs:
        row = read_light(prim, matrices[0], meters_per_unit)
        return None if row is None else np.full(count, row)
    inputs = read_inputs(prim)
    white, are_lit = light_rows([prim.GetPath()], [inputs], np.ones((1, 3)), matrices[:1], meters_per_unit)
    if not are_lit[0]:
        return None
    rows = np.full(count, white[0])
    axes, scales, _ = light_frames(matrices if differs else matrices[:1])
    if differs:
        if (np.abs(scales - scales[:1]) > _SCALE_TOLERANCE * scales[:1]).any():
            raise Unsupported(f"{prim.GetPath()}: the scale of a light cannot differ between worlds")
        rows["x_axis"], rows["y_axis"], rows["z_axis"] = axes[:, 0], axes[:, 1], axes[:, 2]
        rows["position"] = matrices[:, 3, :3]
    colors = emitted_colors(prim, own, count)
    areas, normalized = light_areas([inputs], scales[:1]), np.array([inputs.normalize])
    rows["radiance"], rows["power"] = emission(rows, areas, normalized, colors, meters_per_unit)
    off = rows["radiance"].astype(np.float64) @ LUMINANCE <= 0.0
    rows["visible"][off], rows["power"][off] = 0, 0.0
    return rows


def emitted_colors(prim: Usd.Prim, own: dict[str, np.ndarray], count: int) -> np.ndarray:
    """(worlds, 3) intensity * 2^exposure * color * temperature, as `emitted_color` for one world."""

    def numbers(name: str, default: float) -> np.ndarray:
        if name in own:
            return own[name]
        return np.full(count, light_number(prim, name, default))

    first = FIRST_INTENSITIES.get(str(prim.GetTypeName()), 1.0)
    white = (1.0, 1.0, 1.0)
    if "color" in own:
        refuse_other_space(prim.GetAttribute("inputs:color"))
    color = own["color"] if "color" in own else np.tile(light_value(prim, "color", white), (count, 1))
    color = np.asarray(color, np.float64) * numbers("intensity", first)[:, None]
    color = color * np.exp2(numbers("exposure", 0.0))[:, None]
    enabled = own.get("enableColorTemperature")
    if enabled is None:
        enabled = np.full(count, bool(light_value(prim, "enableColorTemperature", False)))
    if enabled.any():
        kelvin = numbers("colorTemperature", 6500.0)
        same = (kelvin == kelvin[0]).all()
        tints = temperature_color(kelvin[0]) if same else np.stack([temperature_color(each) for each in kelvin])
        color = np.where(enabled[:, None], color * tints, color)
    if not np.isfinite(color).all() or (color < 0.0).any():
        raise Unsupported(f"{prim.GetPath()}: intensity, exposure and color give no light in some world; draw others")
    return color
