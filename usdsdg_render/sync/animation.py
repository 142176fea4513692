"""Find what varies with time on a stage, so that a new time code reads only that again."""

from collections.abc import Iterable

from pxr import Sdf, Usd

from usdsdg.stage.changes import Changes, is_below
from usdsdg.stage.geometry import point_velocities
from usdsdg.stage.geometry.point_velocities import have_velocities
from usdsdg.stage.time_code import attributes_with_values, transform_varies
from usdsdg_render.sync.gprims import Gprims
from usdsdg_render.sync.invalidation import DirtySet
from usdsdg_render.sync.time_varying import Samples, Splines, has_splines_or_clips
from usdsdg_render.usd.prim_kinds import CURVES, DOME, INSTANCER, LIGHT, MESH, POINTS, kind_of
from usdsdg_render.usd.stage_tree import StageTree

# Of these one sample is enough to make point instances, and points of gprims, move.
VELOCITIES = (*point_velocities.VELOCITIES, "angularVelocities")


class Animation:
    """Time samples, splines and value clips of one stage. Without any, everything is read at the default time."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        self._samples, self._splines = Samples(stage), Splines(stage)
        self._varying_names: dict[Sdf.Path, list[str]] = {}  # varying attributes of each prim queried so far
        self._varying_below: dict[Sdf.Path, bool] = {}  # whether a material varies, of those queried so far
        self._tree: StageTree | None = None
        self._transforms: list[Sdf.Path] = []
        self._geometry: set[Sdf.Path] = set()  # gprims of which any attribute varies
        self._gprims: set[Sdf.Path] = set()  # those of them of which more than the geometry varies
        self._inherited: set[Sdf.Path] = set()  # prims with varying primvars, which the gprims below inherit
        self._materials: set[Sdf.Path] = set()
        self._instancers: set[Sdf.Path] = set()
        self._lights: set[Sdf.Path] = set()
        self._visibility: dict[Sdf.Path, object] = {}  # last values of those that vary
        self.is_animated = False
        self.is_surveyed = False  # whether the last `survey` still holds
        self._find_samples({Sdf.Path.absoluteRootPath})

    def _find_samples(self, roots: set[Sdf.Path]) -> None:
        """Find whether anything varies, after what is at and below `roots` has changed; it does until all changes."""
        if Sdf.Path.absoluteRootPath in roots:
            self.is_animated = False
        if not self.is_animated:
            layers = self._stage.GetUsedLayers(includeClipLayers=True)
            # Layers list neither splines nor the samples of clips, which are not open yet.
            self.is_animated = any(layer.ListAllTimeSamples() for layer in layers) or any(
                has_splines_or_clips(self._stage, root) for root in roots
            )

    def apply(self, changes: Changes) -> None:
        """Take note of edits: a script may author the first time samples of a stage, or of an attribute."""
        if changes.resynced:
            self._samples.forget()
            self._splines.forget()
            self._find_samples(changes.resynced)
        properties = changes.properties
        sampled = self._samples.of(properties, changes.recomposed)
        sampled |= self._splines.of(properties)
        sampled |= {path for path, names in changes.changed.items() if not names.isdisjoint(VELOCITIES)}
        sampled |= {path for path in changes.changed.keys() & self._varying_names.keys() if self._varying_names[path]}
        self.is_animated = self.is_animated or bool(sampled)
        if stale := changes.resynced | sampled:
            if any(map(Usd.Prim.IsPathInPrototype, stale)):
                stale = {Sdf.Path.absoluteRootPath}  # here, prims of instances have the paths of their proxies
            self._varying_names = {
                path: names for path, names in self._varying_names.items() if not is_below(path, stale)
            }
            self._varying_below = {
                path: varies
                for path, varies in self._varying_below.items()
                if not is_below(path, stale) and not any(each.HasPrefix(path) for each in stale)
            }
            self.is_surveyed = False

    def survey(self, tree: StageTree, gprims: Gprims) -> None:
        """Find what varies among the drawn prims, for `add_to`."""
        self._tree = tree
        varying = {path: names for path, prim in zip(tree.paths, tree.prims) if (names := self._names(path, prim))}
        self._transforms = [path for path in varying if transform_varies(tree.prims[tree.index[path]])]
        self._lights = {path for path in varying if tree.kinds[tree.index[path]] in (LIGHT, DOME)}
        self._instancers = {path for path in varying if tree.kinds[tree.index[path]] == INSTANCER}
        # An instancer varies with its prototypes.
        prototypes = ((self._stage.GetPrimAtPath(path), users) for path, users in gprims.instancers_of.items())
        self._instancers.update(*(users for prim, users in prototypes if prim and self._varies_below(prim)))
        self._inherited = {path for path, names in varying.items() if any(n.startswith("primvars:") for n in names)}
        self._geometry, self._gprims = set(), set()
        for gprim in gprims.drawn:
            names = [n for prim in (gprim.prim, *gprim.subsets) for n in self._names(prim.GetPath(), prim)]
            names = [name for name in names if name != "visibility" and not name.startswith("xformOp")]
            if names:
                self._geometry.add(gprim.path)
            if any(":" in name for name in names):
                self._gprims.add(gprim.path)
        self._inherited = {path for path in self._inherited if path not in self._geometry or tree.has_children(path)}
        self._visibility = self._visibilities(tree.time)
        self.is_surveyed = True

    def survey_materials(self, paths: Iterable[Sdf.Path]) -> None:
        """Find which of the bound materials vary."""
        self._materials = {path for path in paths if self._is_varying(path)}

    @property
    def geometry(self) -> set[Sdf.Path]:
        """Gprims whose own attributes vary, as of the last survey."""
        return self._geometry

    def add_to(self, dirty: DirtySet, time: Usd.TimeCode) -> None:
        """Add what must be read again because the time code is `time` now."""
        dirty.transforms.update(self._transforms)
        dirty.gprims |= self._gprims
        dirty.geometry |= self._geometry
        dirty.inherited |= self._inherited
        dirty.instancers |= self._instancers
        dirty.lights |= self._lights
        dirty.materials |= self._materials
        visibility = self._visibilities(time)
        dirty.visibility.update(path for path, value in visibility.items() if self._visibility.get(path) != value)
        self._visibility = visibility

    def _names(self, path: Sdf.Path, prim: Usd.Prim) -> list[str]:
        """Names of the attributes that may vary."""
        if path not in self._varying_names:
            kind = kind_of(prim)
            moves = kind == INSTANCER or (kind in (MESH, POINTS, CURVES) and have_velocities(prim))
            velocities = VELOCITIES if moves else ()
            attributes = attributes_with_values(prim)
            self._varying_names[path] = [
                a.GetName() for a in attributes if a.ValueMightBeTimeVarying() or a.GetName() in velocities
            ]
        return self._varying_names[path]

    def _is_varying(self, material: Sdf.Path) -> bool:
        if material not in self._varying_below:
            prim = self._stage.GetPrimAtPath(material)
            self._varying_below[material] = bool(prim) and self._varies_below(prim)
        return self._varying_below[material]

    def _varies_below(self, root: Usd.Prim) -> bool:
        """Whether a prim or one below it varies."""
        below = Usd.PrimRange(root, Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate))
        return any(self._names(prim.GetPath(), prim) for prim in below)

    def _visibilities(self, time: Usd.TimeCode) -> dict[Sdf.Path, object]:
        if self._tree is None:
            return {}
        # Of prims that are gone, or were made anew, the tree has not heard yet.
        known = ((path, attribute) for path, attribute in self._tree.varying_visibility.items() if attribute)
        return {path: attribute.Get(time) for path, attribute in known}
