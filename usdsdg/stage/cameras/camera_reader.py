"""Cameras of one stage, read again only after changes that concern them."""

from collections.abc import Callable

from pxr import Sdf, Usd

from usdsdg.stage.cameras.camera_view import CameraView, read_camera
from usdsdg.stage.change_tracker import ChangeTracker
from usdsdg.stage.changes import Changes
from usdsdg.stage.prims.instances import places_of

_Key = tuple[str, tuple[int, int]]


class CameraReader:
    """Reads cameras as `read_camera`; views that did not change are the same objects."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        self._changes = ChangeTracker(stage)
        self._views: dict[_Key, tuple[Usd.TimeCode, CameraView]] = {}
        # What each view was read from: the camera, and all above, whose transforms place it.
        self._sources: dict[Sdf.Path, set[_Key]] = {}
        self._products: dict[Sdf.Path, _Key] = {}  # what the prim of a render product says
        self._others: set[Sdf.Path] = set()  # what has changed and concerns none of them
        self._harmless: Changes | None = None  # the last changes, if they are such

    def read_product(self, path: str, shown: Callable[[], tuple[_Key, bool]], *, time: Usd.TimeCode) -> CameraView:
        """Return the camera that a render product at `path` shows, at `time`; raises as `read_camera`.

        shown: reads path and resolution, and whether they stay so until the prim at `path` changes.
        """
        self._forget_changed()
        prim_path = Sdf.Path(path)
        key = self._products.get(prim_path)
        if key is None:
            key, stays = shown()
            if stays:
                self._products[prim_path] = key
                self._look_at(prim_path)
        return self.read(*key, time=time)

    def read(self, path: str, resolution: tuple[int, int], *, time: Usd.TimeCode) -> CameraView:
        """Return the camera at `path`, or the only one below it, at `time`; raises as `read_camera`."""
        self._forget_changed()
        key = path, (int(resolution[0]), int(resolution[1]))
        known = self._views.get(key)
        if known is None or known[0] != time:
            view = read_camera(self._stage, *key, time=time)
            self._views[key] = time, view
            for source in (
                Sdf.Path.absoluteRootPath,
                *Sdf.Path(view.prim_path).GetPrefixes(),
            ):  # the root has the units
                self._look_at(source)
                self._sources[source].add(key)
            return view
        return known[1]

    def _look_at(self, source: Sdf.Path) -> None:
        """Follow what changes on a prim."""
        if source not in self._sources:
            self._sources[source] = set()
            self._others.clear()
            self._harmless = None

    def _forget_changed(self) -> None:
        if self._changes.is_empty:
            return
        changes = self._changes.take()
        if changes is self._harmless:  # mostly the same properties change from frame to frame
            return
        if changes.resynced:
            # Of a path above cameras, another one may be the only one now.
            self._views.clear()
            self._sources.clear()
            self._products.clear()
        for path in set(changes.edited) - self._others:
            source = path if path == Sdf.Path.absoluteRootPath else path.GetPrimPath()
            followed = [place for place in places_of(self._stage, source) if place in self._sources]
            if not followed:
                self._others.add(path)
            for place in followed:
                for key in self._sources[place]:
                    self._views.pop(key, None)
                self._products.pop(place, None)
        concerns_none = not changes.resynced and self._others.issuperset(changes.edited)
        self._harmless = changes if concerns_none else None

    def close(self) -> None:
        """Stop listening to the stage."""
        self._changes.close()
