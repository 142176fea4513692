"""What on a stage changes with time, so that a new time costs no more than that."""

from __future__ import annotations

from collections.abc import Iterable

from pxr import Sdf, Usd, UsdGeom

from usdsdg.stage.changes import Changes

from .gprims import Gprim
from .plan import Plan
from .stage_tree import DOME, INSTANCER, LIGHT, Tree


class Animation:
    """Time samples and value clips of one stage. Without any, everything is read at the default time."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        self._tree: Tree | None = None
        self._moving: list[int] = []  # tree nodes
        self._shapes: set[Sdf.Path] = set()  # gprims
        self._materials: set[Sdf.Path] = set()
        self._lights = self._structure = False
        self._seen: tuple[object, ...] = ()  # visibilities when last asked
        self.animated = False
        self.look()

    def look(self) -> None:
        """Find out whether any layer of the stage has time samples."""
        layers = self._stage.GetUsedLayers(includeClipLayers=True)
        self.animated = any(layer.ListAllTimeSamples() for layer in layers)

    def notice(self, changes: Changes) -> None:
        """A script may author the first time samples of a stage."""
        if changes.resynced:
            self.look()
        if self.animated:
            return
        samples_of = self._stage.GetEditTarget().GetLayer().GetNumTimeSamplesForPath
        self.animated = any(
            samples_of(path.AppendProperty(name))
            for path, names in changes.changed.items()
            for name in names
            if name and path.IsPrimPath()
        )

    def survey(self, tree: Tree, gprims: Iterable[Gprim], *, points: bool, time: Usd.TimeCode) -> None:
        """Note what varies among what is drawn, for `add_to`."""
        self._tree = tree
        varying = [bool(_varying(prim)) for prim in tree.prims]
        self._moving = [k for k, prim in enumerate(tree.prims) if varying[k] and _moves(prim)]
        self._lights = any(varying[k] for k in tree.of_kind(LIGHT, DOME))
        # Points may carry anything that varies in their prototypes, which are not in the tree; colours are materials.
        self._structure = points or any(varying[k] for k in tree.of_kind(INSTANCER))
        self._shapes = set()
        for gprim in gprims:
            names = [name for prim in (gprim.prim, *gprim.subsets) for name in _varying(prim)]
            if any(name != "visibility" and not name.startswith("xformOp") for name in names):
                self._shapes.add(gprim.path)
            self._structure |= any(name.startswith("primvars:display") for name in names)
        self._seen = self._visibilities(time)

    def survey_materials(self, paths: Iterable[Sdf.Path]) -> None:
        """Note which of the bound materials vary."""
        prims = (self._stage.GetPrimAtPath(path) for path in paths)
        self._materials = {
            prim.GetPath() for prim in prims if prim and any(_varying(each) for each in Usd.PrimRange(prim))
        }

    @property
    def shapes(self) -> set[Sdf.Path]:
        """Gprims whose own attributes vary, as of the last survey."""
        return self._shapes

    def add_to(self, plan: Plan, time: Usd.TimeCode) -> None:
        """What to read again because it is `time` now."""
        plan.moved |= set(self._moving)
        plan.shapes |= self._shapes
        plan.lights |= self._lights
        plan.materials |= self._materials
        seen = self._visibilities(time)
        plan.structure |= self._structure or seen != self._seen
        self._seen = seen

    def _visibilities(self, time: Usd.TimeCode) -> tuple[object, ...]:
        return tuple(attribute.Get(time) for attribute in self._tree.blinking) if self._tree is not None else ()


def _varying(prim: Usd.Prim) -> list[str]:
    """Names of the attributes that may vary."""
    return [a.GetName() for a in prim.GetAuthoredAttributes() if a.ValueMightBeTimeVarying()]


def _moves(prim: Usd.Prim) -> bool:
    xformable = UsdGeom.Xformable(prim)
    return bool(xformable) and xformable.TransformMightBeTimeVarying()
