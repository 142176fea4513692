"""What on a stage changes with time, so that a new time costs no more than that."""

from __future__ import annotations

from collections.abc import Iterable

from pxr import Sdf, Usd, UsdGeom

from usdsdg.stage.changes import Changes
from usdsdg_render.sync.gprims import Gprims
from usdsdg_render.sync.invalidation import Plan
from usdsdg_render.usd.prim_kinds import DOME, INSTANCER, LIGHT, is_below, kind_of
from usdsdg_render.usd.stage_tree import Tree

# One sample of these is enough to move points.
SPEEDS = ("velocities", "accelerations", "angularVelocities")


class Animation:
    """Time samples and value clips of one stage. Without any, everything is read at the default time."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        self._varying: dict[Sdf.Path, list[str]] = {}  # attributes of prims asked so far
        self._asked: dict[Sdf.Path, bool] = {}  # whether materials vary
        self._tree: Tree | None = None
        self._moving: list[Sdf.Path] = []
        self._shapes: set[Sdf.Path] = set()  # gprims
        self._looks: set[Sdf.Path] = set()  # those of them that look different
        self._inherited: set[Sdf.Path] = set()  # prims that hand values to the gprims below
        self._materials: set[Sdf.Path] = set()
        self._instancers: set[Sdf.Path] = set()
        self._lights: set[Sdf.Path] = set()
        self._seen: dict[Sdf.Path, object] = {}  # visibilities when last asked
        self.animated = False
        self.is_surveyed = False  # the survey still holds
        self.look()

    def look(self) -> None:
        """Find out whether any layer of the stage has time samples."""
        layers = self._stage.GetUsedLayers(includeClipLayers=True)
        self.animated = any(layer.ListAllTimeSamples() for layer in layers)

    def notice(self, changes: Changes) -> None:
        """A script may author the first time samples of a stage, or of an attribute."""
        if changes.resynced:
            self.look()
        samples_of = self._stage.GetEditTarget().GetLayer().GetNumTimeSamplesForPath
        sampled = {path.GetPrimPath() for path in changes.properties if samples_of(path)}
        sampled |= {path for path, names in changes.changed.items() if not names.isdisjoint(SPEEDS)}
        sampled |= {path for path in changes.changed.keys() & self._varying.keys() if self._varying[path]}
        self.animated = self.animated or bool(sampled)
        if stale := changes.resynced | sampled:
            self._varying = {path: names for path, names in self._varying.items() if not is_below(path, stale)}
            self._asked = {
                path: varies
                for path, varies in self._asked.items()
                if not is_below(path, stale) and not any(each.HasPrefix(path) for each in stale)
            }
            self.is_surveyed = False

    def survey(self, tree: Tree, gprims: Gprims) -> None:
        """Note what varies among what is drawn, for `add_to`."""
        self._tree = tree
        varying = {path: names for path, prim in zip(tree.paths, tree.prims) if (names := self._names(path, prim))}
        self._moving = [path for path in varying if _moves(tree.prims[tree.index[path]])]
        self._lights = {path for path in varying if tree.kinds[tree.index[path]] in (LIGHT, DOME)}
        self._instancers = {path for path in varying if tree.kinds[tree.index[path]] == INSTANCER}
        # What varies in their prototypes, points carry along.
        sources = ((self._stage.GetPrimAtPath(path), instancers) for path, instancers in gprims.sources.items())
        self._instancers.update(*(instancers for prim, instancers in sources if prim and self._varies_below(prim)))
        self._inherited = {path for path, names in varying.items() if any(n.startswith("primvars:") for n in names)}
        self._shapes, self._looks = set(), set()
        for gprim in gprims.drawn:
            names = [n for prim in (gprim.prim, *gprim.subsets) for n in self._names(prim.GetPath(), prim)]
            names = [name for name in names if name != "visibility" and not name.startswith("xformOp")]
            if names:
                self._shapes.add(gprim.path)
            if any(":" in name for name in names):
                self._looks.add(gprim.path)
        self._seen = self._visibilities(tree.time)
        self.is_surveyed = True

    def survey_materials(self, paths: Iterable[Sdf.Path]) -> None:
        """Note which of the bound materials vary."""
        self._materials = {path for path in paths if self._is_varying(path)}

    @property
    def shapes(self) -> set[Sdf.Path]:
        """Gprims whose own attributes vary, as of the last survey."""
        return self._shapes

    def add_to(self, plan: Plan, time: Usd.TimeCode) -> None:
        """What to read again because it is `time` now."""
        plan.moved.update(self._moving)
        plan.gprims |= self._looks
        plan.shapes |= self._shapes
        plan.below |= self._inherited - self._shapes
        plan.instancers |= self._instancers
        plan.lights |= self._lights
        plan.materials |= self._materials
        seen = self._visibilities(time)
        plan.shown.update(path for path, value in seen.items() if self._seen.get(path) != value)
        self._seen = seen

    def _names(self, path: Sdf.Path, prim: Usd.Prim) -> list[str]:
        """Names of the attributes that may vary."""
        if path not in self._varying:
            speeds = SPEEDS if kind_of(prim) == INSTANCER else ()
            attributes = prim.GetAuthoredAttributes()
            self._varying[path] = [
                a.GetName() for a in attributes if a.ValueMightBeTimeVarying() or a.GetName() in speeds
            ]
        return self._varying[path]

    def _is_varying(self, material: Sdf.Path) -> bool:
        if material not in self._asked:
            prim = self._stage.GetPrimAtPath(material)
            self._asked[material] = bool(prim) and self._varies_below(prim)
        return self._asked[material]

    def _varies_below(self, root: Usd.Prim) -> bool:
        """Whether a prim or one below it varies."""
        below = Usd.PrimRange(root, Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate))
        return any(self._names(prim.GetPath(), prim) for prim in below)

    def _visibilities(self, time: Usd.TimeCode) -> dict[Sdf.Path, object]:
        if self._tree is None:
            return {}
        return {path: attribute.Get(time) for path, attribute in self._tree.blinking.items()}


def _moves(prim: Usd.Prim) -> bool:
    xformable = UsdGeom.Xformable(prim)
    return bool(xformable) and xformable.TransformMightBeTimeVarying()
