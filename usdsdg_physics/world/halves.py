"""Bodies that are cut where loops of joints close: their second halves, which callers do not see."""

from collections.abc import Mapping, Sequence

import numpy as np

from usdsdg_physics.scene.records import Scene


class Halves:
    """Which body each row of a world's arrays belongs to; second halves are listed after the bodies of the scene."""

    def __init__(self, scene: Scene, body_index: Mapping[str, int]) -> None:
        """`scene` has been cut; `body_index` has the rows of all its bodies."""
        # (N + halves,)
        self.whole = np.array([body_index[scene.halves.get(path, path)] for path in scene.bodies], int)
        self._second = np.array([path in scene.halves for path in scene.bodies], bool)
        self.bodies = [path for path in scene.bodies if path not in scene.halves]

    def __len__(self) -> int:
        """Return how many rows there are, with those of halves."""
        return len(self.whole)

    def follow(self, rows: np.ndarray, indices: Sequence[int] | np.ndarray) -> Sequence[int] | np.ndarray:
        """Give the second halves of bodies `indices` their rows; return the indices of both."""
        if not self._second.any():
            return indices
        halves = np.flatnonzero(self._second & np.isin(self.whole, indices))
        rows[halves] = rows[self.whole[halves]]
        return [*indices, *halves.tolist()]

    @property
    def parts(self) -> np.ndarray:
        """(N + halves,) how many parts the body of each row has."""
        return np.bincount(self.whole)[self.whole] if len(self.whole) else np.ones(0)
