"""The prims of a stage that are, or were, visible, in stage order: one traversal, then only subtrees that changed."""

import itertools
from collections.abc import Collection, Iterable, Sequence, Set
from typing import NamedTuple

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdsdg import errors
from usdsdg.stage.changes import is_below
from usdsdg.stage.geometry.drawn_box import DRAWN_PURPOSES
from usdsdg.stage.prims.handles import Handles
from usdsdg.stage.world_values import OpLayouts, WorldValues
from usdsdg_render.usd import prim_kinds
from usdsdg_render.usd.moved_prims import is_movable
from usdsdg_render.usd.prim_kinds import (
    is_material_subset,
    kind_of,
    purpose_of,
    schemas_of,
    warn_of_lone_subset,
    warn_of_visibility,
    warn_unsupported,
)
from usdsdg_render.usd.transforms import Levels, TransformHierarchy
from usdsdg_render.usd.world_transforms import WorldTransforms

_MODEL, _LEVELS = "GeomModelAPI", "LODRootAPI"


class Node(NamedTuple):
    """One prim of the tree."""

    prim: Usd.Prim
    path: Sdf.Path
    kind: int
    purpose: str  # authored or inherited; "" = none authored
    schemas: tuple[str, ...]  # applied ones, see `schemas_of`
    depth: int  # elements of its path


class Splice(NamedTuple):
    """Replacement of the nodes `first` to `last` (exclusive) by a subtree; an insertion where both are the same."""

    first: int
    last: int
    order: tuple[int, ...]  # among subtrees inserted at the same index
    prim: Usd.Prim | None  # root of the new subtree; None: it was removed
    purpose: str  # inherited by it


class StageTree:
    """Prims in stage order, as parallel lists and arrays.

    Nothing is read below prims that are hidden when they are traversed. Prims that are hidden later stay, so that
    hiding and showing them costs no traversal; `of_kind` leaves them out.

    Args:
        handles: gets the node of each xformOp that was written and does nothing but move it, and `UNREAD` for what was
            written and does not matter: most frames write the same ones. They are forgotten when nodes change.
        always_shown: prims that are in the tree although their visibility says that they are hidden.
    """

    def __init__(
        self,
        stage: Usd.Stage,
        time: Usd.TimeCode,
        handles: Handles,
        always_shown: Set[Sdf.Path] = frozenset(),
    ) -> None:
        self.time = time
        self.always_shown = always_shown
        self.prims: list[Usd.Prim] = []
        self.paths: list[Sdf.Path] = []
        self.kinds: list[int] = []
        self.index: dict[Sdf.Path, int] = {}
        self.drawn: list[bool] = []  # purpose is default or render
        self.subsets: dict[Sdf.Path, list[Usd.Prim]] = {}  # material subsets of meshes
        # Visibility attributes that vary with time, also those of prims that are hidden now.
        self.varying_visibility: dict[Sdf.Path, Usd.Attribute] = {}
        self.skel_roots: set[Sdf.Path] = set()
        self._handles = handles
        self._movable: set[int] = set()  # nodes of which handles were noted since they were read last
        self._layouts = OpLayouts()
        self._stage = stage
        self._other_kinds: dict[Sdf.Path, int] = {}  # of prims that are not in the tree, such as shaders
        self._children_of: dict[Sdf.Path, dict[str, int]] = {}  # during one `resync`
        # The children of prims at the last `resync` of any of them, unless all were traversed since then.
        self._orders: dict[Sdf.Path, dict[str, int]] = {}
        self._transforms = TransformHierarchy(stage, time)
        self._nodes: list[Node] = []
        self._are_parents: list[bool] = []
        self._own_hidden = self._hidden = np.zeros(0, bool)  # nodes that are hidden by their own, or any, visibility
        self.resync({Sdf.Path.absoluteRootPath})

    @property
    def world(self) -> np.ndarray:
        """(nodes, 4, 4) float64 local-to-world."""
        return self._transforms.world

    def places(self, paths: Sequence[Sdf.Path]) -> tuple[np.ndarray, np.ndarray]:
        """Return the rows of `paths` that are in the tree, and the matrices (N, 4, 4) from these prims to the world."""
        nodes = np.array([self.index.get(path, -1) for path in paths], np.int64)
        rows = np.flatnonzero(nodes >= 0)
        return rows, self.world[nodes[rows]]

    def show(self, paths: Iterable[Sdf.Path]) -> None:
        """Read the visibility of prims again that are in the tree."""
        for path in paths:
            if (node := self.index.get(path)) is not None:
                self._own_hidden[node] = self._is_hidden(self.prims[node], path)
        self._hide_below()

    def _hide_below(self) -> None:
        self._hidden = self._own_hidden.copy()
        for children, parents in self._transforms.levels:
            self._hidden[children] |= self._hidden[parents]

    def is_hidden(self, node: int) -> bool:
        """Whether a node is hidden by its own visibility or by one above it."""
        return bool(self._hidden[node])

    def resync(self, roots: Iterable[Sdf.Path]) -> None:
        """Traverse subtrees again in which prims were added or removed, or shown for the first time."""
        roots = set(Sdf.Path.RemoveDescendentPaths(list(roots)))
        self._children_of.clear()
        self._other_kinds.clear()
        # A prim that a weaker layer adds moves those above it, too, before others of their siblings. An opinion that a
        # weaker layer adds of a prim moves it as well, but not before USD composes one of its siblings again.
        above = {prefix.GetParentPath() for root in roots for prefix in root.GetPrefixes()}
        if reordered := list(filter(self._is_reordered, above)):
            roots = set(Sdf.Path.RemoveDescendentPaths([*roots, *reordered]))
        self._drop_notes(roots)
        splices = sorted((splice for root in roots if (splice := self._splice_of(root))), key=lambda s: s[:3])
        nodes: list[Node] = []
        stay: list[tuple[int, int, int]] = []  # spans of nodes that stay: first index after and before, and how many
        begin = 0
        for splice in [*splices, Splice(len(self._nodes), len(self._nodes), (), None, "")]:
            if begin < splice.first:
                stay.append((len(nodes), begin, splice.first - begin))
                nodes += self._nodes[begin : splice.first]
            if splice.prim is not None:
                self._traverse(splice.prim, splice.purpose, nodes)
            begin = splice.last
        self._index_nodes(nodes, *_indices(stay))

    def _drop_notes(self, roots: set[Sdf.Path]) -> None:
        """Drop what `_traverse` noted beside the nodes of prims at and below `roots`."""
        for table in (self.subsets, self.varying_visibility, self._orders):
            for path in [path for path in table if is_below(path, roots)]:
                del table[path]
        self.skel_roots = {path for path in self.skel_roots if not is_below(path, roots)}

    def _is_reordered(self, parent: Sdf.Path) -> bool:
        """Whether children of a prim have another order: one removed and added again becomes the last."""
        if not self._may_have_children(parent):
            return False
        now, before = self._children(parent), self._orders.get(parent)
        self._orders[parent] = now
        if before is not None:  # mostly, and much sooner known than from the nodes
            return [name for name in before if name in now] != [name for name in now if name in before]
        children = (self.index.get(parent.AppendChild(name)) for name in now)
        nodes = [node for node in children if node is not None]
        return nodes != sorted(nodes)

    def _may_have_children(self, path: Sdf.Path) -> bool:
        node = self.index.get(path, -1)
        return path == Sdf.Path.absoluteRootPath or (node >= 0 and self.kinds[node] != prim_kinds.INSTANCER)

    def _splice_of(self, root: Sdf.Path) -> Splice | None:
        """Return how the subtree at `root` enters or leaves the nodes; None where it is not and was not visible."""
        if root == Sdf.Path.absoluteRootPath:
            return Splice(0, len(self._nodes), (), self._stage.GetPseudoRoot(), "")
        parent = root.GetParentPath()
        if not self._may_have_children(parent):
            return None
        prim = self._stage.GetPrimAtPath(root)
        if prim and prim.GetName() not in self._children(parent):
            prim = None
        node = self.index.get(parent)
        purpose = "" if node is None else self._nodes[node].purpose
        first = self.index.get(root)
        if first is not None:
            return Splice(first, self._subtree_end(first), (), prim or None, purpose)
        if not prim:
            return None
        first = self._insertion_index(parent, prim.GetName())
        order = tuple(self._children(path.GetParentPath())[path.name] for path in root.GetPrefixes())
        return Splice(first, first, order, prim, purpose)

    def _children(self, path: Sdf.Path) -> dict[str, int]:
        """Names of the children of a prim in order, with their positions."""
        if path not in self._children_of:
            names = self._stage.GetPrimAtPath(path).GetFilteredChildrenNames(Usd.TraverseInstanceProxies())
            self._children_of[path] = {name: position for position, name in enumerate(names)}
        return self._children_of[path]

    def _insertion_index(self, parent: Sdf.Path, name: str) -> int:
        """Index of a new child: after its nearest preceding sibling in the tree, else right after the parent."""
        positions = self._children(parent)
        for sibling in itertools.islice(reversed(positions), len(positions) - positions[name], None):
            node = self.index.get(parent.AppendChild(sibling))
            if node is not None:
                return self._subtree_end(node)
        return self.index.get(parent, -1) + 1

    def _subtree_end(self, node: int) -> int:
        """Index of the first node after a subtree."""
        depth = self._nodes[node].depth
        node += 1
        while node < len(self._nodes) and self._nodes[node].depth > depth:
            node += 1
        return node

    def _traverse(self, root: Usd.Prim, purpose: str, nodes: list[Node]) -> None:
        """Append the nodes of a subtree."""
        ancestors: list[Node] = []
        iterator = iter(Usd.PrimRange(root, Usd.TraverseInstanceProxies()))
        if root.IsPseudoRoot():
            next(iterator, None)
        for prim in iterator:
            kind = kind_of(prim)
            path = prim.GetPath()
            depth = path.pathElementCount
            while ancestors and ancestors[-1].depth >= depth:
                ancestors.pop()
            if kind == prim_kinds.SUBSET:
                if is_material_subset(prim):
                    if ancestors and ancestors[-1].kind == prim_kinds.MESH and ancestors[-1].depth == depth - 1:
                        self.subsets.setdefault(ancestors[-1].path, []).append(prim)
                    else:
                        warn_of_lone_subset(prim)
                continue
            if kind == prim_kinds.SHADING or self._is_hidden(prim, path):
                iterator.PruneChildren()
                continue
            own_purpose = purpose_of(prim, ancestors[-1].purpose if ancestors else purpose)
            node = Node(prim, path, kind, own_purpose, schemas_of(prim), depth)
            nodes.append(node)
            ancestors.append(node)
            if kind == prim_kinds.INSTANCER:  # its prototypes are drawn through it only
                iterator.PruneChildren()
            elif kind in (prim_kinds.UNSUPPORTED_GPRIM, prim_kinds.UNSUPPORTED_LIGHT) and _is_drawn(node):
                warn_unsupported(prim)
            elif kind == prim_kinds.OTHER or (node.schemas and (_MODEL in node.schemas or _LEVELS in node.schemas)):
                self._note_schemas(node)

    def _index_nodes(self, nodes: list[Node], new: np.ndarray, old: np.ndarray) -> None:
        """Make the lists and arrays of `nodes`; those at the indices `new` were at `old` before."""
        self._nodes = nodes
        self.prims = [node.prim for node in nodes]
        self.paths = [node.path for node in nodes]
        self.kinds = [node.kind for node in nodes]
        self.drawn = [_is_drawn(node) for node in nodes]
        depths = [node.depth for node in nodes]
        self._are_parents = [below > depth for depth, below in zip(depths, [*depths[1:], 0])]
        self.index = {path: k for k, path in enumerate(self.paths)}
        self._handles.forget()
        self._movable = set()
        own_hidden = np.zeros(len(nodes), bool)  # those that were traversed are not
        own_hidden[new] = self._own_hidden[old]
        self._own_hidden = own_hidden
        self._transforms.rebuild(self.prims, _levels(np.array(depths, int)), new, old)
        self._hide_below()

    def _is_hidden(self, prim: Usd.Prim, path: Sdf.Path) -> bool:
        attribute = prim.GetAttribute("visibility")
        if not attribute or path in self.always_shown:
            return False
        if not self.time.IsDefault() and attribute.ValueMightBeTimeVarying():
            self.varying_visibility[path] = attribute
        visibility = attribute.Get(self.time)
        warn_of_visibility(prim, visibility)
        return visibility == UsdGeom.Tokens.invisible

    def _note_schemas(self, node: Node) -> None:
        """Note a SkelRoot; warn of a draw mode and of levels of detail."""
        prim, path = node.prim, node.path
        if prim.GetTypeName() == "SkelRoot":
            self.skel_roots.add(path)
        if _LEVELS in node.schemas:
            errors.warn_once(
                f"{path}: LODRootAPI is not supported; all of its levels of detail are drawn, in one place. Make all "
                f"but one of its children invisible, or deactivate them."
            )
        if prim.HasAPI(UsdGeom.ModelAPI):
            mode = prim.GetAttribute("model:drawMode").Get()
            if mode in ("cards", "bounds", "origin"):
                errors.warn_once(
                    f"{path}: draw mode {mode} is not supported; the full geometry is drawn. Set model:drawMode to "
                    f"default."
                )

    def has_other_schemas(self, path: Sdf.Path) -> bool:
        """Whether the applied schemas of a prim differ from those at its traversal."""
        node, prim = self.index.get(path), self._stage.GetPrimAtPath(path)
        return node is None or not prim or schemas_of(prim) != self._nodes[node].schemas

    def set_time(self, time: Usd.TimeCode) -> None:
        """Read at `time` from now on."""
        self.time = time
        self._transforms.set_time(time)

    def kind_at(self, path: Sdf.Path) -> int:
        """Return the kind of a prim, which may be one that is not in the tree; OTHER where there is none."""
        node = self.index.get(path)
        if node is not None:
            return self.kinds[node]
        kind = self._other_kinds.get(path)
        if kind is None:
            prim = self._stage.GetPrimAtPath(path)
            kind = self._other_kinds[path] = kind_of(prim) if prim else prim_kinds.OTHER
        return kind

    def has_children(self, path: Sdf.Path) -> bool:
        """Whether there are prims of the tree below a prim."""
        node = self.index.get(path)
        return node is not None and self._are_parents[node]

    def of_kind(self, *kinds: int) -> list[int]:
        """Return the visible nodes of these kinds."""
        return [
            k for k, (kind, hidden) in enumerate(zip(self.kinds, self._hidden.tolist())) if kind in kinds and not hidden
        ]

    def note_xform_ops(self, path: Sdf.Path, ops: Sequence[str]) -> None:
        """Note that these ops of a prim do nothing but move its node, while their values stay in one layer."""
        node = self.index.get(path)
        if node is None or not self.time.IsDefault():
            return
        if all(map(is_movable, map(self.prims[node].GetAttribute, ops))):
            self._handles.note(map(path.AppendProperty, ops), node)
            self._movable.add(node)

    def note_unread(self, path: Sdf.Path, names: Iterable[str]) -> None:
        """Note that nothing is read of these properties of a prim."""
        self._handles.note(map(path.AppendProperty, names), prim_kinds.UNREAD)

    def in_worlds(self, values: WorldValues) -> WorldTransforms:
        """Return the world matrices of nodes where attributes have these values."""
        moved = sorted(node for path in values.moved() if (node := self.index.get(path)) is not None)
        local = values.local_matrices_of([self.prims[node] for node in moved], self._layouts)
        ends = [self._subtree_end(node) for node in moved]
        return self._transforms.in_worlds(values.count, moved, local, ends)

    def update_transforms(self, paths: Collection[Sdf.Path], nodes: Iterable[int]) -> None:
        """Read the local matrices of prims and nodes again, where they are in the tree; compose all world matrices.

        nodes: those of which only ops changed that `note_xform_ops` was told of.
        """
        changed = {node for path in paths if (node := self.index.get(path)) is not None}
        movable, self._movable = self._movable & changed, set()
        if not self._transforms.move(self.prims, sorted(set(nodes)), changed, movable):
            self._handles.forget()


def _is_drawn(node: Node) -> bool:
    return not node.purpose or node.purpose in DRAWN_PURPOSES


def _indices(spans: Sequence[tuple[int, int, int]]) -> tuple[np.ndarray, np.ndarray]:
    """Return the indices in spans, after and before a change, each span as (first after, first before, count)."""
    after, before, counts = np.array(spans, int).reshape(-1, 3).T
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return within + np.repeat(after, counts), within + np.repeat(before, counts)


def _levels(depths: np.ndarray) -> Levels:
    """(children, their parents) for each depth below the first, top down, by the depths of nodes in stage order."""
    levels: Levels = []
    for depth in np.unique(depths):
        children, above = np.flatnonzero(depths == depth), np.flatnonzero(depths < depth)
        last = np.searchsorted(above, children) - 1  # of those above, the parent is the one that came last
        if (has_parent := last >= 0).any():
            levels.append((children[has_parent], above[last[has_parent]]))
    return levels
