"""The drawable part of a stage as a tree of prims with their matrices: one traversal, then only what moved."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from pxr import Sdf, Tf, Usd, UsdGeom, UsdLux, UsdShade

from usdsdg import errors

from .lights import DOMES, KINDS, UNSUPPORTED
from .shapes import PARAMETERS

# What a prim is to the renderer.
PASS, MESH, SHAPE, CURVES, POINTS, LIGHT, DOME, INSTANCER, SUBSET, SKIP, UNDRAWN, NO_LIGHT = range(12)
GPRIMS = (MESH, SHAPE, CURVES, POINTS)
DRAWN_PURPOSES = (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)

# Properties that change nothing that is drawn; other engines and scripts write them all the time.
IGNORED_PREFIXES = ("physics:", "physx", "semantic", "newton:", "ui:", "userProperties:", "state:", "drive:")

_KNOWN = {
    "Mesh": MESH,
    "BasisCurves": CURVES,
    "HermiteCurves": CURVES,
    "NurbsCurves": CURVES,
    "Points": POINTS,
    "PointInstancer": INSTANCER,
    "GeomSubset": SUBSET,
    **dict.fromkeys(PARAMETERS, SHAPE),
    **dict.fromkeys(KINDS, LIGHT),
    **dict.fromkeys(DOMES, DOME),
    **dict.fromkeys(UNSUPPORTED, NO_LIGHT),
    "Material": SKIP,
    "Shader": SKIP,
    "NodeGraph": SKIP,
}


def kind_of(prim: Usd.Prim) -> int:
    """What the prim is, by its type name; types that we have not met are asked once for what they derive from."""
    name = str(prim.GetTypeName())
    kind = _KNOWN.get(name)
    if kind is None:
        if prim.IsA(UsdGeom.Mesh):
            kind = MESH
        elif prim.IsA(UsdGeom.PointInstancer):
            kind = INSTANCER
        elif prim.IsA(UsdGeom.Gprim):
            kind = UNDRAWN
        elif prim.IsA(UsdLux.NonboundableLightBase) or prim.IsA(UsdLux.BoundableLightBase):
            kind = NO_LIGHT
        elif prim.IsA(UsdShade.NodeGraph):
            kind = SKIP
        else:
            kind = PASS
        _KNOWN[name] = kind
    return kind


def purpose_of(prim: Usd.Prim, inherited: str) -> str:
    """Purpose authored here, else the parent's. The empty string stands for "none authored"."""
    attribute = prim.GetAttribute("purpose")
    if attribute and attribute.HasAuthoredValue():
        return str(attribute.Get())
    return inherited


def is_invisible(prim: Usd.Prim, time: Usd.TimeCode) -> bool:
    attribute = prim.GetAttribute("visibility")
    return bool(attribute) and attribute.Get(time) == UsdGeom.Tokens.invisible


def local_matrix(cache: UsdGeom.XformCache, prim: Usd.Prim, sampled: bool) -> tuple[np.ndarray, bool]:
    """((4, 4) local matrix, whether it starts a new transform stack).

    At the default time, a prim whose ops have only samples is where its first sample puts it. Ops that USD refuses give
    NaN, so that what they place is dropped by name.
    """
    try:
        matrix, resets = cache.GetLocalTransformation(prim)
    except Tf.ErrorException as failure:
        errors.warn_once(f"{prim.GetPath()}: its xformOps cannot be read. Correct xformOpOrder and its ops. {failure}")
        return np.full((4, 4), np.nan), False
    if sampled:
        xformable = UsdGeom.Xformable(prim)
        if xformable and xformable.TransformMightBeTimeVarying():
            ops = xformable.GetOrderedXformOps()
            if not any(op.Get() is not None for op in ops):
                matrix = xformable.GetLocalTransformation(Usd.TimeCode.EarliestTime())
    return np.array(matrix), bool(resets)


def matrix_product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a @ b, quietly: what is NaN or infinite is dropped by name where it would be drawn."""
    with np.errstate(invalid="ignore", over="ignore"):
        return a @ b


class Tree:
    """Visible prims in stage order, as parallel lists and arrays."""

    def __init__(self, stage: Usd.Stage, time: Usd.TimeCode) -> None:
        self.time = time
        self.prims: list[Usd.Prim] = []
        self.kinds: list[int] = []
        self.index: dict[Sdf.Path, int] = {}
        self.drawn: list[bool] = []  # purpose is default or render
        self.subsets: dict[int, list[Usd.Prim]] = {}
        self.blinking: list[Usd.Attribute] = []  # visibilities that vary with time, also of prims that are hidden now
        self.has_skeletons = False  # there is a SkelRoot
        # Without an authored range nothing is animated; saves a question per prim.
        self._sampled = time.IsDefault() and stage.HasAuthoredTimeCodeRange()
        self._cache = UsdGeom.XformCache(time)
        self._parents: list[int] = []
        self._depths: list[int] = []
        self._walk(stage)
        count = len(self.prims)
        self.local = np.broadcast_to(np.eye(4), (count, 4, 4)).copy()
        self.resets = np.zeros(count, bool)
        self._read_local(range(count))
        self.world = self.local.copy()
        self._levels = self._make_levels()
        self._compose()

    def _walk(self, stage: Usd.Stage) -> None:
        open_prims: list[tuple[int, int, str]] = []  # (depth, index, purpose) from the root to here
        iterator = iter(Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()))
        next(iterator, None)  # the pseudo-root
        for prim in iterator:
            kind = kind_of(prim)
            path = prim.GetPath()
            depth = path.pathElementCount
            while open_prims and open_prims[-1][0] >= depth:
                open_prims.pop()
            _, parent, purpose = open_prims[-1] if open_prims else (0, -1, "")
            if kind == SUBSET:
                if parent >= 0 and self.kinds[parent] == MESH and is_material_subset(prim):
                    self.subsets.setdefault(parent, []).append(prim)
                continue
            if kind == SKIP or self._is_hidden(prim):
                iterator.PruneChildren()
                continue
            purpose = purpose_of(prim, purpose)
            here = len(self.prims)
            self.prims.append(prim)
            self.kinds.append(kind)
            self.index[path] = here
            self.drawn.append(not purpose or purpose in DRAWN_PURPOSES)
            self._parents.append(parent)
            self._depths.append(depth)
            open_prims.append((depth, here, purpose))
            if kind == INSTANCER:  # its prototypes are drawn through it only
                iterator.PruneChildren()
            elif kind in (UNDRAWN, NO_LIGHT) and self.drawn[-1]:
                warn_unsupported(prim)
            elif kind == PASS:
                self._note_look(prim)

    def _is_hidden(self, prim: Usd.Prim) -> bool:
        attribute = prim.GetAttribute("visibility")
        if not attribute:
            return False
        if not self.time.IsDefault() and attribute.ValueMightBeTimeVarying():
            self.blinking.append(attribute)
        return attribute.Get(self.time) == UsdGeom.Tokens.invisible

    def _note_look(self, prim: Usd.Prim) -> None:
        """Schemas that change how what is below looks."""
        if prim.GetTypeName() == "SkelRoot":
            self.has_skeletons = True
        if prim.HasAPI(UsdGeom.ModelAPI):
            mode = prim.GetAttribute("model:drawMode").Get()
            if mode in ("cards", "bounds", "origin"):
                errors.warn_once(f"{prim.GetPath()}: draw mode {mode} is not supported; the full geometry is drawn.")

    def set_time(self, time: Usd.TimeCode) -> None:
        """What `move` reads from now on is of this time."""
        self.time = time
        self._cache.SetTime(time)

    def of_kind(self, *kinds: int) -> list[int]:
        return [k for k, kind in enumerate(self.kinds) if kind in kinds]

    def move(self, moved: Iterable[int]) -> None:
        """Read the local matrices of prims again and everything below them."""
        self._cache.Clear()
        self._read_local(moved)
        self._compose()

    def _read_local(self, which: Iterable[int]) -> None:
        for k in which:
            self.local[k], self.resets[k] = local_matrix(self._cache, self.prims[k], self._sampled)

    def _make_levels(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """(children, their parents) for each depth below the first, top down."""
        depths, parents = np.array(self._depths, np.int64), np.array(self._parents, np.int64)
        levels = []
        for depth in np.unique(depths):
            children = np.flatnonzero((depths == depth) & (parents >= 0))
            if len(children):
                levels.append((children, parents[children]))
        return levels

    def _compose(self) -> None:
        self.world[...] = self.local
        for children, parents in self._levels:
            worlds = matrix_product(self.local[children], self.world[parents])
            self.world[children] = np.where(self.resets[children, None, None], self.local[children], worlds)


def is_material_subset(subset: Usd.Prim) -> bool:
    """Whether a GeomSubset partitions the faces of its mesh for materials."""
    family = subset.GetAttribute("familyName").Get()
    element = subset.GetAttribute("elementType").Get()
    return family == UsdShade.Tokens.materialBind and element in (None, UsdGeom.Tokens.face)


def warn_unsupported(prim: Usd.Prim) -> None:
    """Name a gprim or light of a kind that is not drawn."""
    kind = prim.GetTypeName()
    if kind == "PortalLight":
        errors.warn_once(
            f"{prim.GetPath()}: PortalLight is not supported and changes nothing: it would only guide how a dome light "
            f"is sampled. Give the picture more samples where light comes through openings."
        )
        return
    what = "shines no light" if kind_of(prim) == NO_LIGHT else "is not drawn"
    remedy = (
        "Use one of the lights " + ", ".join((*KINDS, *DOMES)) if kind_of(prim) == NO_LIGHT else "Convert it to a Mesh"
    )
    errors.warn_once(f"{prim.GetPath()}: {kind} is not supported and {what}. {remedy}.")
