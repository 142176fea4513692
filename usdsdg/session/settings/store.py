"""The settings store: keys such as `/rtx/rendermode`, which scripts read and write through `carb.settings`.

`DEFAULTS` lists the keys that have an effect here. Any other key can be stored and read back, because scripts set many
that only affect a user interface.
"""

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from enum import IntEnum
from typing import Any

from usdsdg.errors import Unsupported
from usdsdg.listeners import Listeners
from usdsdg.session.session import current
from usdsdg.session.settings.items import Item, ItemType, UpdateAction, is_accessible

DEFAULTS: dict[str, Any] = {
    "/app/player/playSimulations": True,
    "/exts/omni.kit.hydra_texture/renderProduct/path/prefix": "HydraTextures/",
    "/omni/replicator/RTSubframes": 1,
    "/omni/replicator/captureOnPlay": True,
    "/omni/replicator/captureMotionBlur": False,
    "/omni/replicator/pathTracedMotionBlurSubSamples": 8,
    "/omni/replicator/globalSeed": -1,
    "/omni/replicator/backends/disk/root_dir": "",
    "/omni/replicator/backend/queueSize": 1000,
    "/omni/replicator/backend/writeThreads": 4,
    "/physics/updateVelocitiesToUsd": True,
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
    "/usdsdg/capture/picturesLater": True,
    "/usdsdg/denoiser": "auto",
    "/usdsdg/labels/glass": "surface",
    "/usdsdg/labels/stableIds": True,
    "/usdsdg/labels/semanticClasses": None,
    "/usdsdg/labels/closedClasses": False,
    "/usdsdg/labels/record": True,
    "/usdsdg/labels/recordStage": True,
    "/usdsdg/progress": True,
    "/usdsdg/replicator/version": 0,
    "/usdsdg/writers/queueBytes": 1 << 30,
    "/syntheticdata/sensors/perSubsetSegmentation": False,
}


_UNSET = object()


def lets_files_run_code(path: str) -> bool:
    """Return whether a setting decides that scripts of a stage run: no file may set it, only the running program."""
    return f"{normalized(path)}/".startswith("/app/scripting/")


def normalized(path: str) -> str:
    """Return a key with one leading slash and no empty elements: `rtx//rendermode/` is `/rtx/rendermode`."""
    return "/" + "/".join(part for part in path.split("/") if part)


def _flat(key: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Yield the keys and values of a dictionary that is set at a key; the setting of a known key may be one itself."""
    if isinstance(value, Mapping) and value and key not in DEFAULTS:
        for name, each in value.items():
            yield from _flat(normalized(f"{key}/{name}"), each)
    else:
        yield key, value


class ChangeEventType(IntEnum):
    """What happened to a setting, for those who subscribed to it."""

    CREATED, CHANGED, DESTROYED = range(3)


class Settings:
    """A flat store of typed values under normalized paths."""

    def __init__(self) -> None:
        self._values: dict[str, Any] = dict(DEFAULTS)
        self._listeners: dict[str, Listeners[[Any]]] = {}
        # Listeners by the path of a tree: each is called with the path of a setting that changed at or below it.
        self._tree_listeners: dict[str, Listeners[[str, ChangeEventType]]] = {}
        self._removal_listeners: dict[str, Listeners[[]]] = {}
        self._subscriptions: dict[int, Callable[[], None]] = {}
        self._numbers = itertools.count(1)

    def get(self, path: str) -> Any:
        """Return the value at `path`, a dictionary of what is below it, or None if there is neither."""
        key = normalized(path)
        if key in self._values:
            return self._values[key]
        return self._below(key)

    def _below(self, key: str) -> dict[str, Any] | None:
        """Return the values below a key as nested dictionaries; None where there are none."""
        found: dict[str, Any] = {}
        start = key.rstrip("/") + "/"
        for name, value in self._values.items():
            if name.startswith(start):
                *parents, last = name.removeprefix(start).split("/")
                holder = found
                for parent in parents:
                    inner = holder.get(parent)
                    holder[parent] = holder = inner if isinstance(inner, dict) else {}
                holder[last] = value
        return found or None

    def set(self, path: str, value: Any) -> None:
        """Store `value` and call the listeners of that key; a dictionary takes the place of all that is below.

        Settings that have an effect here get their defaults back, where they are not in the dictionary.
        """
        key = normalized(path)
        wanted = dict(_flat(key, value))
        if key not in wanted:
            for name in [
                name for name in self._values if name.startswith(key.rstrip("/") + "/") and name not in wanted
            ]:
                if name not in DEFAULTS:
                    self._remove(name)
                elif self._values[name] != DEFAULTS[name]:
                    wanted[name] = DEFAULTS[name]
        for name, each in wanted.items():
            self._set(name, each)

    def _set(self, key: str, value: Any) -> None:
        change = ChangeEventType.CREATED if self._values.get(key) is None else ChangeEventType.CHANGED
        self._values[key] = value
        if key in self._listeners:
            self._listeners[key].call(value)
        self._tell_trees(key, change)

    def _remove(self, key: str) -> None:
        del self._values[key]
        if key in self._removal_listeners:
            self._removal_listeners[key].call()
        self._tell_trees(key, ChangeEventType.DESTROYED)

    def _tell_trees(self, key: str, change: ChangeEventType) -> None:
        for tree, told in list(self._tree_listeners.items()):
            if key == tree or key.startswith(tree.rstrip("/") + "/"):
                told.call(key, change)

    def set_default(self, path: str, value: Any) -> None:
        """Store `value` unless the key has one; of a dictionary each value whose key has none."""
        for key, each in _flat(normalized(path), value):
            self._values.setdefault(key, each)

    def changed(self) -> dict[str, Any]:
        """Return the keys whose values differ from their defaults."""
        return {key: value for key, value in self._values.items() if DEFAULTS.get(key, _UNSET) != value}

    def destroy_item(self, path: str) -> None:
        """Remove a key and everything below it."""
        key = normalized(path)
        for name in [name for name in self._values if name == key or name.startswith(key.rstrip("/") + "/")]:
            self._remove(name)

    def on_change(self, path: str, listener: Callable[[Any], None]) -> Callable[[], None]:
        """Call `listener(value)` whenever the key is set; return the unsubscriber."""
        return self._listeners.setdefault(normalized(path), Listeners()).subscribe(listener)

    def subscribe_to_node_change_events(self, path: str, fn: Callable[[Any, ChangeEventType], Any]) -> int:
        """Call `fn(value, event type)` whenever the key is set or removed; return the number that ends it."""
        had = [self.get(path) is not None]

        def tell(value: Any) -> None:
            change = ChangeEventType.CHANGED if had[0] else ChangeEventType.CREATED
            had[0] = True
            fn(value, change)

        def tell_removed() -> None:
            had[0] = False
            fn(None, ChangeEventType.DESTROYED)

        removals = self._removal_listeners.setdefault(normalized(path), Listeners())
        return self._subscribed(self.on_change(path, tell), removals.subscribe(tell_removed))

    def subscribe_to_tree_change_events(self, path: str, fn: Callable[[Item, Item, ChangeEventType], Any]) -> int:
        """Call `fn(item of the path, item that changed, event type)` for all below; return the number that ends it."""
        tree = normalized(path)

        def tell(key: str, change: ChangeEventType) -> None:
            fn(Item(self, tree), Item(self, key), change)

        return self._subscribed(self._tree_listeners.setdefault(tree, Listeners()).subscribe(tell))

    def _subscribed(self, *ends: Callable[[], None]) -> int:
        def end_all() -> None:
            for end in ends:
                end()

        number = next(self._numbers)
        self._subscriptions[number] = end_all
        return number

    def unsubscribe_to_change_events(self, subscription: int) -> None:
        """End a subscription; nothing if it has ended."""
        self._subscriptions.pop(subscription, lambda: None)()

    # --- trees ---
    def get_settings_dictionary(self, path: str = "") -> Item | None:
        """Return what is at a path as an item, which changes with the settings and changes them; None for nothing."""
        key = normalized(path)
        return None if self.get(key) is None else Item(self, key)

    def create_dictionary_from_settings(self, path: str = "") -> Item | None:
        """Return a copy of what is at a path as an item; None where there is nothing."""
        if (value := self.get(path)) is None:
            return None
        copy = Settings()
        copy._values = dict(_flat("/", value))
        return Item(copy, "/")

    def update(self, path: str, dictionary: Item, dictionary_path: str, update_policy: Any) -> None:
        """Set what is below `dictionary_path` of an item at a path.

        update_policy: an `UpdateAction`, for keys that have a value here.

        Raises:
            Unsupported: the policy is a function.
        """
        if not isinstance(update_policy, UpdateAction):
            raise Unsupported(
                "ISettings.update: of policies there are carb.dictionary.UpdateAction.OVERWRITE and KEEP, functions "
                "are not called; set the values that they would choose"
            )
        value = dictionary.get(dictionary_path) if dictionary_path.strip("/") else dictionary.get_dict()
        for key, each in _flat(normalized(path), value):
            if update_policy is UpdateAction.OVERWRITE or self._values.get(key) is None:
                self.set(key, each)

    def initialize_from_dictionary(self, dictionary: Item) -> None:
        """Set all values of an item, below the root."""
        self.update("/", dictionary, "", UpdateAction.OVERWRITE)

    def is_accessible_as(self, item_type: ItemType, path: str) -> bool:
        """Return whether the value at a path can be read as one of a type."""
        return is_accessible(item_type, self.get(path))

    # carb.settings has one getter and setter per type.
    def get_as_int(self, path: str) -> int:
        """Return the value as an integer; 0 if it is not set."""
        return int(self.get(path) or 0)

    def get_as_float(self, path: str) -> float:
        """Return the value as a float; 0.0 if it is not set."""
        return float(self.get(path) or 0.0)

    def get_as_bool(self, path: str) -> bool:
        """Return the value as a bool; False if it is not set."""
        return bool(self.get(path))

    def get_as_string(self, path: str) -> str:
        """Return the value as a string; "" if it is not set."""
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

    def set_bool_array(self, path: str, value: Sequence[bool]) -> None:
        self.set(path, [bool(each) for each in value])

    def set_int_array(self, path: str, value: Sequence[int]) -> None:
        self.set(path, [int(each) for each in value])

    def set_float_array(self, path: str, value: Sequence[float]) -> None:
        self.set(path, [float(each) for each in value])

    def set_string_array(self, path: str, value: Sequence[str]) -> None:
        self.set(path, [str(each) for each in value])

    def set_default_int(self, path: str, value: int) -> None:
        self.set_default(path, int(value))

    def set_default_float(self, path: str, value: float) -> None:
        self.set_default(path, float(value))

    def set_default_bool(self, path: str, value: bool) -> None:
        self.set_default(path, bool(value))

    def set_default_string(self, path: str, value: str) -> None:
        self.set_default(path, str(value))


def get_settings() -> Settings:
    """Return the settings of the session (`carb.settings.get_settings()`)."""
    return current().settings


def captures_motion_blur() -> bool:
    """Return whether pictures show the motion of a frame, where they are path traced."""
    return get_settings().get_as_bool("/omni/replicator/captureMotionBlur")


def captures_on_play() -> bool:
    """Return whether a playing timeline is captured, and runs and steps play it: `orchestrator.set_capture_on_play`."""
    return get_settings().get_as_bool("/omni/replicator/captureOnPlay")
