"""World matrices of the nodes of a stage tree in many worlds: only those that differ are kept."""

from collections.abc import Sequence

import numpy as np

Levels = Sequence[tuple[np.ndarray, np.ndarray]]
_IDENTITY = np.eye(4)


def matrix_product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a @ b without NumPy's warnings: gprims with NaN or infinite matrices are reported where they would be drawn."""
    with np.errstate(invalid="ignore", over="ignore"):
        return a @ b


class WorldTransforms:
    """World matrices of nodes in `count` worlds; nodes below none that has moved are where they are on the stage."""

    def __init__(self, count: int, world: np.ndarray, moved: Sequence[int], ends: Sequence[int]) -> None:
        """world: (nodes, 4, 4) on the stage. moved, ends: the first nodes of subtrees, and the ends of these."""
        self.count = count
        self._world = world
        affected = np.zeros(len(world), bool)
        for first, end in zip(moved, ends, strict=True):
            affected[first:end] = True
        self._row = np.where(affected, np.cumsum(affected) - 1, -1)  # of `_matrices`
        self._moved = np.full(len(world), -1)
        self._moved[list(moved)] = np.arange(len(moved))
        self._matrices = np.empty((count, int(affected.sum()), 4, 4))

    def compose(self, local: np.ndarray, moved: np.ndarray, resets: np.ndarray, levels: Levels) -> None:
        """Compose the matrices top down.

        local: (nodes, 4, 4) on the stage. moved: (worlds or 1, moved, 4, 4) local matrices. levels: (children, their
        parents) for each depth below the first.
        """
        is_child = np.zeros(len(local), bool)
        for children, _ in levels:
            is_child[children] = True
        roots = np.flatnonzero((self._row >= 0) & ~is_child)
        self._compose(roots, None, local, moved, resets)
        for children, parents in levels:
            here = self._row[children] >= 0
            # Most prims that stand still are gprims at the origin of what carries them: they are where that is.
            carried = here & (self._moved[children] < 0) & ~resets[children]
            carried[carried] = (local[children[carried]] == _IDENTITY).all((1, 2))
            self._row[children[carried]] = self._row[parents[carried]]
            here &= ~carried
            if here.any():
                self._compose(children[here], parents[here], local, moved, resets)

    def _compose(
        self, nodes: np.ndarray, parents: np.ndarray | None, local: np.ndarray, moved: np.ndarray, resets: np.ndarray
    ) -> None:
        has_moved = self._moved[nodes] >= 0
        if parents is None:
            above = np.broadcast_to(_IDENTITY, (1, len(nodes), 4, 4))
        else:
            above = self.at(parents)
        still = nodes[~has_moved]
        if len(still):
            self._matrices[:, self._row[still]] = matrix_product(local[still], above[:, ~has_moved])
        if has_moved.any():
            own, carried = moved[:, self._moved[nodes[has_moved]]], above[:, has_moved]
            product = own if (carried == _IDENTITY).all() else matrix_product(own, carried)
            self._matrices[:, self._row[nodes[has_moved]]] = product
        for node in nodes[resets[nodes]]:
            alone = moved[:, self._moved[node]] if self._moved[node] >= 0 else local[node]
            self._matrices[:, self._row[node]] = alone

    def at(self, nodes: np.ndarray) -> np.ndarray:
        """(worlds, nodes, 4, 4) world matrices; (1, nodes, 4, 4) if they are the same in all worlds."""
        nodes = np.asarray(nodes, np.int64)
        rows = self._row[nodes]
        if not (rows >= 0).any():
            return self._world[nodes][None]
        if (rows >= 0).all():
            return np.take(self._matrices, rows, axis=1)
        found = np.empty((self.count, len(nodes), 4, 4))
        found[:] = self._world[nodes]
        found[:, rows >= 0] = self._matrices[:, rows[rows >= 0]]
        return found
