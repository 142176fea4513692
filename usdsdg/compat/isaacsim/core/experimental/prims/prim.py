"""The base of all wrappers: which prims."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Usd

from usdsdg.compat.isaacsim.core.simulation_manager.simulation import simulation
from usdsdg.compat.wrappers import prim_paths
from usdsdg.compat.wrappers.arrays import as_warp, chosen

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.wrappers.arrays import Indices


class Prim:
    """One or more prims of the current stage."""

    def __init__(self, paths: str | Sequence[str], *, resolve_paths: bool = True) -> None:
        """Wrap the prims at these paths; between slashes a path may have regular expressions.

        Raises:
            AssertionError: there are no such prims.
            ValueError: a pattern matches nothing.
        """
        if resolve_paths:
            found, missing = self.resolve_paths(paths)
            if missing:
                raise AssertionError(f"there are no prims at {', '.join(missing)}; define them first")
        else:
            found = [paths] if isinstance(paths, str) else list(paths)
        self._paths = found
        self._prims = [prim_paths.prim_of(path) for path in found]

    def __len__(self) -> int:
        return len(self._paths)

    @property
    def paths(self) -> list[str]:
        return self._paths

    @property
    def prims(self) -> list[Usd.Prim]:
        return self._prims

    @property
    def valid(self) -> bool:
        """Whether all prims are still on the stage."""
        return all(prim.IsValid() for prim in self._prims)

    @staticmethod
    def ensure_api(prims: Sequence[Usd.Prim], api: type, *args: Any, **kwargs: Any) -> list[Any]:
        """Apply a schema to the prims that lack it; return its objects."""
        return [
            api(prim, *args, **kwargs) if prim.HasAPI(api) else api.Apply(prim, *args, **kwargs)  # pyright: ignore[reportAttributeAccessIssue]
            for prim in prims
        ]

    @staticmethod
    def resolve_paths(paths: str | Sequence[str], raise_on_mixed_paths: bool = True) -> tuple[list[str], list[str]]:
        """Return (paths of existing prims, paths without a prim).

        Raises:
            ValueError: some exist and others do not, or a pattern matches nothing.
        """
        if raise_on_mixed_paths:
            return prim_paths.split_paths(paths)
        given = [paths] if isinstance(paths, str) else list(paths)
        found = {path: prim_paths.matching_paths(path) for path in given}
        return [each for path in given for each in found[path]], [path for path in given if not found[path]]

    def _chosen(self, indices: Indices) -> list[Usd.Prim]:
        """Return the prims of some rows.

        Raises:
            AssertionError: a prim has been removed from the stage.
        """
        if not self.valid:
            gone = [path for path, prim in zip(self._paths, self._prims, strict=True) if not prim.IsValid()]
            raise AssertionError(f"{', '.join(gone)}: removed from the stage, so the wrapper is not valid any more")
        return [self._prims[index] for index in chosen(indices, len(self))]

    def _warp(self, array: np.ndarray) -> wp.array:
        return as_warp(array, simulation().device)
