"""The skeletons of a stage."""

from pxr import Sdf, Usd, UsdSkel


class SkeletonPrims:
    """Finds the skeletons of a stage once, and again after `invalidate`: to go through all prims takes a while."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        self._paths: list[Sdf.Path] | None = None  # None: not known

    def invalidate(self) -> None:
        """Look for skeletons again."""
        self._paths = None

    def find(self) -> list[Sdf.Path]:
        """Return the paths of all skeletons, shown or not, in stage order; those of instances are proxies."""
        if self._paths is None:
            prims = self._stage.Traverse(Usd.TraverseInstanceProxies())
            self._paths = [prim.GetPath() for prim in prims if prim.IsA(UsdSkel.Skeleton)]
        return self._paths
