"""Local and world matrices of the prims of a stage tree, in USD's row-vector convention (float64)."""

import math
from collections.abc import Sequence, Set

import numpy as np
from pxr import Gf, Tf, Usd, UsdGeom, Vt

from usdsdg import errors
from usdsdg.stage.usd_errors import reason
from usdsdg_render.usd.moved_prims import MovedPrims
from usdsdg_render.usd.op_order import warn_of_lost_ops
from usdsdg_render.usd.world_transforms import Levels, WorldTransforms, matrix_product

_AFFINE = (0.0, 0.0, 0.0, 1.0)  # the last column of a matrix of row vectors
_MOST_PROJECTIVE = 1e-6  # of files that store matrices in 32 bits


class TransformHierarchy:
    """Matrices of the nodes of a tree: local ones are read from USD, world ones composed level by level."""

    def __init__(self, stage: Usd.Stage, time: Usd.TimeCode) -> None:
        self.local = self.world = np.zeros((0, 4, 4))
        self._stage = stage
        self._cache = UsdGeom.XformCache(time)
        self._moved_prims = MovedPrims()
        self._resets = np.zeros(0, bool)  # nodes with !resetXformStack!
        self.levels: Levels = ()  # (children, their parents) for each depth below the first, top down

    def set_time(self, time: Usd.TimeCode) -> None:
        """Read matrices at `time` from now on."""
        self._cache.SetTime(time)

    def rebuild(self, prims: Sequence[Usd.Prim], levels: Levels, new: np.ndarray, old: np.ndarray) -> None:
        """Take over the nodes of a changed tree.

        Args:
            levels: (children, their parents) for each depth below the first, top down.
            new, old: index after and before the change of the nodes that stayed; all others are read.
        """
        self.levels = levels
        self._moved_prims.forget()  # nodes are others
        local, resets = np.broadcast_to(np.eye(4), (len(prims), 4, 4)).copy(), np.zeros(len(prims), bool)
        local[new], resets[new] = self.local[old], self._resets[old]
        self.local, self._resets = local, resets
        self.world = local.copy()
        added = np.setdiff1d(np.arange(len(prims)), new, assume_unique=True).tolist()
        for node in added:
            warn_of_lost_ops(prims[node])
        self.update(prims, added)

    def move(self, prims: Sequence[Usd.Prim], moved: Sequence[int], changed: Set[int], movable: Set[int]) -> bool:
        """Read the local matrices of nodes again and compose all world matrices.

        Args:
            moved: nodes that were `movable` before, and of which only values of the ops have changed that this was
                said of.
            changed: all other nodes to read.
            movable: those of `changed` that this and the next calls may take for `moved`; see `MovedPrims`.

        Returns:
            Whether nodes may be taken for `moved` at the next call; if not, none of them was movable.
        """
        kept = [*moved, *movable]
        found = self._moved_prims.read(prims, kept) if self._moved_prims.holds(moved, changed) else None
        if found is None:
            self._moved_prims.forget()
            kept = []
        else:
            self._take(prims, kept, found)
        self.update(prims, sorted(changed.union(moved).difference(kept)))
        return found is not None

    def update(self, prims: Sequence[Usd.Prim], nodes: list[int]) -> None:
        """Read the local matrices of `nodes` again and compose all world matrices."""
        self._cache.Clear()
        # Without an authored time code range nothing is animated; this saves a query per prim.
        sampled = self._cache.GetTime().IsDefault() and self._stage.HasAuthoredTimeCodeRange()
        self._take(prims, nodes, local_matrices(self._cache, [prims[k] for k in nodes], sampled))
        self.world[...] = self.local
        for children, parents in self.levels:
            worlds = matrix_product(self.local[children], self.world[parents])
            self.world[children] = np.where(self._resets[children, None, None], self.local[children], worlds)

    def _take(self, prims: Sequence[Usd.Prim], nodes: list[int], found: Sequence[tuple[Gf.Matrix4d, bool]]) -> None:
        if found:
            self.local[nodes] = np.array(Vt.Matrix4dArray([matrix for matrix, _ in found]))
            self._resets[nodes] = [resets for _, resets in found]
            _make_affine(prims, nodes, self.local)

    def in_worlds(self, count: int, moved: list[int], local: np.ndarray, ends: list[int]) -> WorldTransforms:
        """Compose the world matrices of nodes with other local matrices in each of `count` worlds.

        moved: nodes, whose local matrices are (worlds or 1, moved, 4, 4). ends: of their subtrees, exclusive.
        """
        worlds = WorldTransforms(count, self.world, moved, ends)
        worlds.compose(self.local, local, self._resets, self.levels)
        return worlds


def _make_affine(prims: Sequence[Usd.Prim], nodes: list[int], local: np.ndarray) -> None:
    """Let matrices at `nodes` do no more than turn, scale, shear and move, with a warning where they do more."""
    off = np.abs(local[nodes, :, 3] - _AFFINE).max(axis=1) > _MOST_PROJECTIVE  # not so for NaN
    for node in np.asarray(nodes)[off].tolist():
        column = tuple(local[node, :, 3].tolist())
        errors.warn_once(
            f"{prims[node].GetPath()}: its transform is a projection, since the last column of its matrix is {column}; "
            f"that column is ignored. Author a matrix whose last column is (0, 0, 0, 1)."
        )
        local[node, :, 3] = _AFFINE


def local_matrix(cache: UsdGeom.XformCache, prim: Usd.Prim, sampled: bool) -> tuple[Gf.Matrix4d, bool]:
    """Return (local matrix, whether it resets the transform stack).

    sampled: whether a prim whose ops have time samples only takes the first one at the default time. Ops that USD
        rejects give NaN with a warning, so that the gprims they place are dropped.
    """
    try:
        matrix, resets = cache.GetLocalTransformation(prim)
    except Tf.ErrorException as failure:
        cache.Clear()  # else it would give a matrix without the ops that it rejected, when it is asked again
        errors.warn_once(
            f"{prim.GetPath()}: its xformOps cannot be read: {reason(failure).rstrip('.')}; what it places is not "
            f"drawn. Correct xformOpOrder and its ops."
        )
        return Gf.Matrix4d(*[math.nan] * 16), False
    if sampled:
        xformable = UsdGeom.Xformable(prim)
        if xformable and xformable.TransformMightBeTimeVarying():
            ops = xformable.GetOrderedXformOps()
            if not any(op.Get() is not None for op in ops):
                matrix = xformable.GetLocalTransformation(Usd.TimeCode.EarliestTime())
    return matrix, resets


def local_matrices(
    cache: UsdGeom.XformCache, prims: Sequence[Usd.Prim], sampled: bool
) -> list[tuple[Gf.Matrix4d, bool]]:
    """Return `local_matrix` of many prims."""
    if not sampled:
        try:
            return list(map(cache.GetLocalTransformation, prims))
        except Tf.ErrorException:  # one of them is broken: find it below
            cache.Clear()
    return [local_matrix(cache, prim, sampled) for prim in prims]
