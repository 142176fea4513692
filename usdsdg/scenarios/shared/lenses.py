"""The lens of a camera without a calibration."""

from __future__ import annotations

import math

from pxr import UsdGeom

DEFAULT_SIZE = (640, 480)
_APERTURE = 20.955


def author_field_of_view(camera: UsdGeom.Camera, degrees: float) -> None:
    """Make a camera a pinhole that sees an angle across its pictures."""
    camera.CreateHorizontalApertureAttr(_APERTURE)
    camera.CreateFocalLengthAttr(_APERTURE / 2.0 / math.tan(math.radians(degrees / 2.0)))
