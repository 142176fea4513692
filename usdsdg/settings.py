"""The settings tree: keys such as `/rtx/rendermode`, as scripts read and write them through `carb.settings`.

Mirrors the keys of spec "settings" that have a meaning here; any other key can be stored and read back, because scripts
toggle many that only matter to a user interface.
"""

from __future__ import annotations

from collections.abc import Callable
from numbers import Integral, Real
from typing import Any

from usdsdg.errors import ConfigError

DEFAULTS: dict[str, Any] = {
    "/app/player/playSimulations": True,
    "/omni/replicator/RTSubframes": 1,
    "/omni/replicator/captureOnPlay": True,
    "/omni/replicator/captureMotionBlur": False,
    "/omni/replicator/pathTracedMotionBlurSubSamples": 8,
    "/omni/replicator/globalSeed": -1,
    "/omni/replicator/backends/disk/root_dir": "",
    "/omni/replicator/backend/queueSize": 1000,
    "/rtx/rendermode": "RaytracedLighting",
    "/rtx/pathtracing/spp": 1,
    "/rtx/pathtracing/totalSpp": 64,
    "/rtx/pathtracing/maxBounces": 3,
    "/rtx/pathtracing/maxSpecularAndTransmissionBounces": 6,
    "/rtx/pathtracing/optixDenoiser/enabled": True,
    "/rtx/pathtracing/optixDenoiser/blendFactor": 0.0,
    "/rtx/pathtracing/multimatte/channelCount": 0,
    "/rtx/post/tonemap/filmIso": 100.0,
    "/rtx/post/tonemap/cameraShutter": 50.0,
    "/rtx/post/tonemap/fNumber": 5.0,
    "/rtx/post/depthSensor/baselineMM": 55.0,
    "/rtx/post/depthSensor/focalLengthPixel": 897.0,
    "/rtx/post/depthSensor/sensorSizePixel": 1280.0,
    "/rtx/post/depthSensor/maxDisparityPixel": 110.0,
    "/rtx/post/depthSensor/confidenceThreshold": 0.7,
    "/rtx/post/depthSensor/noiseMean": 0.25,
    "/rtx/post/depthSensor/noiseSigma": 0.25,
    "/rtx/post/depthSensor/noiseDownscaleFactorPixel": 1.0,
    "/rtx/post/depthSensor/outlierRemovalEnabled": True,
    "/rtx/post/depthSensor/minDistance": 0.5,
    "/rtx/post/depthSensor/maxDistance": 10000000.0,
    "/rtx/post/depthSensor/rgbDepthOutputMode": 0,
    "/rtx/post/depthSensor/showDistance": False,
    "/usdsdg/denoiser": "auto",
    "/usdsdg/labels/glass": "surface",
    "/syntheticdata/sensors/perSubsetSegmentation": False,
}


_UNSET = object()


def normalised(path: str) -> str:
    """`rtx//rendermode/` and `/rtx/rendermode` are one key."""
    return "/" + "/".join(part for part in path.split("/") if part)


class Settings:
    """A flat store of typed values under normalised paths."""

    def __init__(self) -> None:
        self._values: dict[str, Any] = dict(DEFAULTS)
        self._listeners: dict[str, list[Callable[[Any], None]]] = {}

    def get(self, path: str) -> Any:
        """The value at `path`, or None where nothing was set."""
        return self._values.get(normalised(path))

    def set(self, path: str, value: Any) -> None:
        """Store `value` and tell the listeners of that key."""
        key = normalised(path)
        self._values[key] = value
        for listener in self._listeners.get(key, []):
            listener(value)

    def set_default(self, path: str, value: Any) -> None:
        """Store `value` unless the key has one."""
        self._values.setdefault(normalised(path), value)

    def changed(self) -> dict[str, Any]:
        """What was set to something else than its default."""
        return {key: value for key, value in self._values.items() if DEFAULTS.get(key, _UNSET) != value}

    def destroy_item(self, path: str) -> None:
        """Forget a key and everything below it."""
        key = normalised(path)
        for name in [name for name in self._values if name == key or name.startswith(key + "/")]:
            del self._values[name]

    def on_change(self, path: str, listener: Callable[[Any], None]) -> Callable[[], None]:
        """Call `listener(value)` whenever the key is set; returns the function that ends it."""
        listeners = self._listeners.setdefault(normalised(path), [])
        listeners.append(listener)
        return lambda: listeners.remove(listener) if listener in listeners else None

    # carb.settings has one getter and setter per type.
    def get_as_int(self, path: str) -> int:
        """The value as a whole number; 0 where nothing was set."""
        return int(self.get(path) or 0)

    def get_as_float(self, path: str) -> float:
        """The value as a number; 0.0 where nothing was set."""
        return float(self.get(path) or 0.0)

    def get_as_bool(self, path: str) -> bool:
        """The value as true or false; False where nothing was set."""
        return bool(self.get(path))

    def get_as_string(self, path: str) -> str:
        """The value as text; "" where nothing was set."""
        value = self.get(path)
        return "" if value is None else str(value)

    def set_int(self, path: str, value: int) -> None:
        self.set(path, int(value))

    def set_float(self, path: str, value: float) -> None:
        self.set(path, float(value))

    def set_bool(self, path: str, value: bool) -> None:
        self.set(path, bool(value))

    def set_string(self, path: str, value: str) -> None:
        self.set(path, str(value))


_settings = Settings()


def get_settings() -> Settings:
    """The process-wide settings (`carb.settings.get_settings()`)."""
    return _settings


# --- rep.settings ---


def carb_settings(setting: str, value: Any) -> Any:
    """Set one key; to a constant now, to a draw of a distribution whenever the enclosing trigger fires.

    Returns:
        the graph's item for a distribution, None for a constant.
    """
    if not hasattr(value, "sample"):
        _settings.set(setting, value)
        return None
    from usdsdg.graph.evaluate import graph
    from usdsdg.graph.node import Node, ReplicatorItem

    return ReplicatorItem(graph().add(Node("OgnCarbSettings", {"attribute": normalised(setting), "value": value})))


def write_drawn_setting(node: Any, execution: int) -> None:
    """What a `carb_settings` node does at each execution."""
    key = node.inputs["attribute"]
    drawn = node.inputs["value"].sample(f"{node.key}/value", execution, [key])[0]
    _settings.set(key, drawn.tolist() if hasattr(drawn, "tolist") else drawn)


def get_physx_timestep() -> float:
    """Seconds of one physics step on the current stage: its first PhysicsScene's, or 1/60."""
    from usdsdg.session.stage_context import current_stage
    from usdsdg.stage.physics.scenes import physics_scene, steps_per_second

    return 1.0 / steps_per_second(physics_scene(current_stage()))


def set_physx_timestep(timestep: float) -> None:
    """Author how long a physics step is [s], on the stage's first PhysicsScene, made where there is none.

    Raises:
        ConfigError: (a ValueError) it is not above 0.
    """
    from usdsdg.session.stage_context import current_stage
    from usdsdg.stage.physics.scenes import set_steps_per_second

    if not isinstance(timestep, Real) or not timestep > 0:
        raise ConfigError(f"settings.set_physx_timestep: {timestep!r} must be above 0 seconds")
    set_steps_per_second(current_stage(), 1.0 / timestep)


def set_render_rtx_realtime(antialiasing: str = "FXAA") -> None:
    """Capture in the fast mode: few samples per pixel, then an edge-preserving filter.

    `antialiasing` (off, TAA, FXAA, DLSS, DLAA) goes to `/rtx/post/aa/op` as its number in Omniverse; pictures are
    filtered alike for all of them.

    Raises:
        ConfigError: (a ValueError) another antialiasing.
    """
    operations = {"off": 0, "taa": 1, "fxaa": 2, "dlss": 3, "dlaa": 4}
    if str(antialiasing).lower() not in operations:
        raise ConfigError(f"antialiasing is {antialiasing!r}; expected one of {', '.join(operations)}")
    _settings.set("/rtx/rendermode", "RaytracedLighting")
    _settings.set("/rtx/post/aa/op", operations[str(antialiasing).lower()])


def set_render_pathtraced(samples_per_pixel: int = 64) -> None:
    """Capture with the path tracer at `samples_per_pixel`.

    Raises:
        ConfigError: (a ValueError) it is no whole number, or below 1.
    """
    if not isinstance(samples_per_pixel, Integral) or samples_per_pixel < 1:
        raise ConfigError(f"samples_per_pixel is {samples_per_pixel!r}; expected a whole number, 1 or more")
    _settings.set("/rtx/rendermode", "PathTracing")
    _settings.set("/rtx/pathtracing/totalSpp", int(samples_per_pixel))


def set_stage_up_axis(up_axis: str) -> None:
    """Author the stage's up axis, "Y" or "Z" (any case).

    Raises:
        ConfigError: (a ValueError) another axis.
    """
    from pxr import UsdGeom

    from usdsdg.session.stage_context import current_stage

    if str(up_axis).upper() not in ("Y", "Z"):
        raise ConfigError(f"up axis is {up_axis!r}; expected 'Y' or 'Z'")
    UsdGeom.SetStageUpAxis(current_stage(), up_axis.upper())


def set_stage_meters_per_unit(meters_per_unit: float) -> None:
    """Author the stage's linear unit [metres]: 0.01 for centimetres.

    Raises:
        ConfigError: (a ValueError) it is not above 0.
    """
    from pxr import UsdGeom

    from usdsdg.session.stage_context import current_stage

    if not isinstance(meters_per_unit, Real) or not meters_per_unit > 0:
        raise ConfigError(f"metres per unit is {meters_per_unit!r}; expected a number above 0")
    UsdGeom.SetStageMetersPerUnit(current_stage(), float(meters_per_unit))
