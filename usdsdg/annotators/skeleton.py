"""Skeleton data: known, not built."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from usdsdg.annotators.base import Annotation, define
from usdsdg.annotators.frame import Frame
from usdsdg.errors import Unsupported


@define("skeleton_data", params={"useSkelJoints": False})
def skeleton_data(frame: Frame, params: Mapping[str, Any]) -> Annotation:
    """Joints of UsdSkel characters; raises `Unsupported`."""
    raise Unsupported(
        f"{frame.render_product}: annotator 'skeleton_data' is not implemented. Leave it out of the writer, or "
        "read the joints from the stage with UsdSkel."
    )
