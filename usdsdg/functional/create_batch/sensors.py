"""Sensors of Replicator that usdsdg does not support."""

from typing import Any

from pxr import Usd

from usdsdg.errors import Unsupported


def omni_lidar(
    position: Any = None, rotation: Any = None, count: int = 1, name: str | None = None, parent: Any = None,
    **attributes: Any,
) -> list[Usd.Prim]:  # fmt: skip
    """Unsupported: usdsdg has no lidar model."""
    raise Unsupported(
        "omni_lidar: usdsdg simulates no lidar; use a camera with the annotators distance_to_camera or pointcloud"
    )


def omni_radar(
    position: Any = None, rotation: Any = None, count: int = 1, name: str | None = None, parent: Any = None,
    **attributes: Any,
) -> list[Usd.Prim]:  # fmt: skip
    """Unsupported: usdsdg has no radar model."""
    raise Unsupported("omni_radar: usdsdg simulates no radar; use a camera with the annotator distance_to_camera")
