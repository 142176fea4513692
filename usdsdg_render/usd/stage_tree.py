"""The drawable part of a stage as a tree of prims with their matrices: one traversal, then only what changed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from pxr import Sdf, Usd, UsdGeom, Vt

from usdsdg import errors
from usdsdg_render.usd.prim_kinds import (
    DRAWN_PURPOSES,
    INSTANCER,
    MESH,
    NO_LIGHT,
    PASS,
    SKIP,
    SUBSET,
    UNDRAWN,
    is_below,
    is_material_subset,
    kind_of,
    local_matrices,
    matrix_product,
    purpose_of,
    schemas_of,
    warn_unsupported,
)


class Node(NamedTuple):
    """One prim of the tree."""

    prim: Usd.Prim
    path: Sdf.Path
    kind: int
    purpose: str  # its own or inherited; "" = none authored
    schemas: tuple[str, ...]  # applied, those that matter
    depth: int  # elements of its path


class Place(NamedTuple):
    """Where a subtree goes: instead of the nodes `first` to `last`, or between two where they are the same."""

    first: int
    last: int
    order: tuple[int, ...]  # among subtrees that go to the same place
    prim: Usd.Prim | None  # None: it is gone
    purpose: str  # above it


class Tree:
    """Visible prims in stage order, as parallel lists and arrays."""

    def __init__(self, stage: Usd.Stage, time: Usd.TimeCode) -> None:
        self.time = time
        self.prims: list[Usd.Prim] = []
        self.paths: list[Sdf.Path] = []
        self.kinds: list[int] = []
        self.index: dict[Sdf.Path, int] = {}
        self.drawn: list[bool] = []  # purpose is default or render
        self.subsets: dict[Sdf.Path, list[Usd.Prim]] = {}  # of meshes
        # Visibilities that vary with time, also of prims that are hidden now.
        self.blinking: dict[Sdf.Path, Usd.Attribute] = {}
        self.skeletons: set[Sdf.Path] = set()  # prims that are a SkelRoot
        # Xform ops that were written before and do no more than move a node: most frames write the same ones again.
        self.movers: dict[Sdf.Path, int] = {}
        self.local = self.world = np.zeros((0, 4, 4))
        self.resets = np.zeros(0, bool)
        self._stage = stage
        self._children_of: dict[Sdf.Path, list[str]] = {}  # names, during one `regrow`
        self._cache = UsdGeom.XformCache(time)
        self._nodes: list[Node] = []
        self.regrow({Sdf.Path.absoluteRootPath})

    def regrow(self, roots: Iterable[Sdf.Path]) -> None:
        """Walk subtrees again in which prims came, went, or were hidden or shown; all other nodes stay."""
        roots = set(Sdf.Path.RemoveDescendentPaths(list(roots)))
        self._children_of.clear()
        if reordered := [root.GetParentPath() for root in roots if self._has_changed_places(root)]:
            roots = set(Sdf.Path.RemoveDescendentPaths([*roots, *reordered]))
        self._forget(roots)
        places = sorted((place for root in roots if (place := self._place_of(root))), key=lambda p: p[:3])
        nodes: list[Node] = []
        kept: list[np.ndarray] = []  # (new, old) numbers of nodes that stay
        begin = 0
        for place in [*places, Place(len(self._nodes), len(self._nodes), (), None, "")]:
            old = np.arange(begin, place.first)
            kept.append(np.stack([old - begin + len(nodes), old]))
            nodes += self._nodes[begin : place.first]
            if place.prim is not None:
                self._walk(place.prim, place.purpose, nodes)
            begin = place.last
        self._number(nodes, *np.concatenate(kept, axis=1))

    def _forget(self, roots: set[Sdf.Path]) -> None:
        """What is noted of prims at and below `roots`."""
        for table in (self.subsets, self.blinking):
            for path in [path for path in table if is_below(path, roots)]:
                del table[path]
        self.skeletons = {path for path in self.skeletons if not is_below(path, roots)}

    def _has_changed_places(self, root: Sdf.Path) -> bool:
        """Whether siblings stand in another order than their nodes: a prim that went and came back is the last."""
        node, above = self.index.get(root), root.GetParentPath()
        if node is None or not self._has_nodes_below(above) or root.name not in self._children(above):
            return False
        return self._behind_siblings(above, root.name) != node

    def _has_nodes_below(self, path: Sdf.Path) -> bool:
        node = self.index.get(path, -1)
        return path == Sdf.Path.absoluteRootPath or (node >= 0 and self.kinds[node] != INSTANCER)

    def _place_of(self, root: Sdf.Path) -> Place | None:
        """None for what is not drawn, nor was."""
        if root == Sdf.Path.absoluteRootPath:
            return Place(0, len(self._nodes), (), self._stage.GetPseudoRoot(), "")
        above = root.GetParentPath()
        if not self._has_nodes_below(above):
            return None
        prim = self._stage.GetPrimAtPath(root)
        if prim and prim.GetName() not in self._children(above):
            prim = None
        node = self.index.get(above)
        purpose = "" if node is None else self._nodes[node].purpose
        first = self.index.get(root)
        if first is not None:
            return Place(first, self._end(first), (), prim or None, purpose)
        if not prim:
            return None
        first = self._behind_siblings(above, prim.GetName())
        order = tuple(self._children(path.GetParentPath()).index(path.name) for path in root.GetPrefixes())
        return Place(first, first, order, prim, purpose)

    def _children(self, path: Sdf.Path) -> list[str]:
        if path not in self._children_of:
            prim = self._stage.GetPrimAtPath(path)
            self._children_of[path] = prim.GetFilteredChildrenNames(Usd.TraverseInstanceProxies())
        return self._children_of[path]

    def _behind_siblings(self, above: Sdf.Path, name: str) -> int:
        """Where a new child goes: after the nearest sibling before it that is in the tree, else first."""
        names = self._children(above)
        for sibling in reversed(names[: names.index(name)]):
            node = self.index.get(above.AppendChild(sibling))
            if node is not None:
                return self._end(node)
        return self.index.get(above, -1) + 1

    def _end(self, node: int) -> int:
        """The first node behind a subtree."""
        depth = self._nodes[node].depth
        node += 1
        while node < len(self._nodes) and self._nodes[node].depth > depth:
            node += 1
        return node

    def _walk(self, root: Usd.Prim, purpose: str, nodes: list[Node]) -> None:
        """Append the nodes of a subtree."""
        above: list[Node] = []  # from the root to here
        iterator = iter(Usd.PrimRange(root, Usd.TraverseInstanceProxies()))
        if root.IsPseudoRoot():
            next(iterator, None)
        for prim in iterator:
            kind = kind_of(prim)
            path = prim.GetPath()
            depth = path.pathElementCount
            while above and above[-1].depth >= depth:
                above.pop()
            if kind == SUBSET:
                if above and above[-1].kind == MESH and is_material_subset(prim):
                    self.subsets.setdefault(above[-1].path, []).append(prim)
                continue
            if kind == SKIP or self._is_hidden(prim, path):
                iterator.PruneChildren()
                continue
            own_purpose = purpose_of(prim, above[-1].purpose if above else purpose)
            node = Node(prim, path, kind, own_purpose, schemas_of(prim), depth)
            nodes.append(node)
            above.append(node)
            if kind == INSTANCER:  # its prototypes are drawn through it only
                iterator.PruneChildren()
            elif kind in (UNDRAWN, NO_LIGHT) and _is_drawn(node):
                warn_unsupported(prim)
            elif kind == PASS:
                self._note_look(prim, path)

    def _number(self, nodes: list[Node], new: np.ndarray, old: np.ndarray) -> None:
        """Make the lists and arrays of `nodes`, of which those numbered `new` had the numbers `old`."""
        self._nodes = nodes
        self.prims = [node.prim for node in nodes]
        self.paths = [node.path for node in nodes]
        self.kinds = [node.kind for node in nodes]
        self.drawn = [_is_drawn(node) for node in nodes]
        self.index = {path: k for k, path in enumerate(self.paths)}
        self.movers = {}
        self._levels = _levels(nodes)
        local, resets = np.broadcast_to(np.eye(4), (len(nodes), 4, 4)).copy(), np.zeros(len(nodes), bool)
        local[new], resets[new] = self.local[old], self.resets[old]
        self.local, self.resets = local, resets
        self.world = local.copy()
        self._cache.Clear()
        self._read_local(np.setdiff1d(np.arange(len(nodes)), new, assume_unique=True).tolist())
        self._compose()

    def _is_hidden(self, prim: Usd.Prim, path: Sdf.Path) -> bool:
        attribute = prim.GetAttribute("visibility")
        if not attribute:
            return False
        if not self.time.IsDefault() and attribute.ValueMightBeTimeVarying():
            self.blinking[path] = attribute
        return attribute.Get(self.time) == UsdGeom.Tokens.invisible

    def _note_look(self, prim: Usd.Prim, path: Sdf.Path) -> None:
        """Schemas that change how what is below looks."""
        if prim.GetTypeName() == "SkelRoot":
            self.skeletons.add(path)
        if prim.HasAPI(UsdGeom.ModelAPI):
            mode = prim.GetAttribute("model:drawMode").Get()
            if mode in ("cards", "bounds", "origin"):
                errors.warn_once(f"{path}: draw mode {mode} is not supported; the full geometry is drawn.")

    def has_other_schemas(self, path: Sdf.Path) -> bool:
        """Whether the applied schemas of a prim are not what they were when it was walked."""
        node, prim = self.index.get(path), self._stage.GetPrimAtPath(path)
        return node is None or not prim or schemas_of(prim) != self._nodes[node].schemas

    def set_time(self, time: Usd.TimeCode) -> None:
        """What is read from now on is of this time."""
        self.time = time
        self._cache.SetTime(time)

    def of_kind(self, *kinds: int) -> list[int]:
        return [k for k, kind in enumerate(self.kinds) if kind in kinds]

    def note_movers(self, path: Sdf.Path, ops: Iterable[str]) -> None:
        """Note that these ops of a prim do no more than move it."""
        node = self.index.get(path)
        if node is not None:
            self.movers.update((path.AppendProperty(op), node) for op in ops)

    def move(self, moved: Iterable[Sdf.Path], nodes: Iterable[int]) -> None:
        """Read the local matrices of prims and nodes again, where they are in the tree, and everything below them."""
        self._cache.Clear()
        found = {node for path in moved if (node := self.index.get(path)) is not None}
        self._read_local(sorted(found.union(nodes)))
        self._compose()

    def _read_local(self, which: list[int]) -> None:
        # Without an authored range nothing is animated; saves a question per prim.
        sampled = self.time.IsDefault() and self._stage.HasAuthoredTimeCodeRange()
        found = local_matrices(self._cache, [self.prims[k] for k in which], sampled)
        if found:
            self.local[which] = np.array(Vt.Matrix4dArray([matrix for matrix, _ in found]))
            self.resets[which] = [resets for _, resets in found]

    def _compose(self) -> None:
        self.world[...] = self.local
        for children, parents in self._levels:
            worlds = matrix_product(self.local[children], self.world[parents])
            self.world[children] = np.where(self.resets[children, None, None], self.local[children], worlds)


def _is_drawn(node: Node) -> bool:
    return not node.purpose or node.purpose in DRAWN_PURPOSES


def _levels(nodes: Sequence[Node]) -> list[tuple[np.ndarray, np.ndarray]]:
    """(children, their parents) for each depth below the first, top down; nodes are in stage order."""
    levels: dict[int, tuple[list[int], list[int]]] = {}
    above: list[tuple[int, int]] = []  # (depth, number) from the root to here
    for k, node in enumerate(nodes):
        while above and above[-1][0] >= node.depth:
            above.pop()
        if above:
            children, parents = levels.setdefault(node.depth, ([], []))
            children.append(k)
            parents.append(above[-1][1])
        above.append((node.depth, k))
    return [(np.array(children), np.array(parents)) for _, (children, parents) in sorted(levels.items())]
