"""`omni.replicator.core.scripts.utils.annotator_utils`: what scripts replace to read a camera without overscan."""

from __future__ import annotations

from typing import Any

__all__: list[str] = []


def _resize_data_for_overscan(data: Any, *_: Any, **__: Any) -> Any:
    """Return the image itself: nothing is rendered beyond the edges of a picture, and nothing calls this."""
    return data
