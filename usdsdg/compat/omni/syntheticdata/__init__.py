"""`omni.syntheticdata`: the sensors of a viewport, read one by one."""

from usdsdg.compat.omni.syntheticdata import _syntheticdata, helpers, sensors, visualize
from usdsdg.compat.omni.syntheticdata.synthetic_data import (
    SyntheticData,
    SyntheticDataException,
    SyntheticDataStage,
)

__all__ = [
    "SyntheticData", "SyntheticDataException", "SyntheticDataStage", "_syntheticdata", "helpers", "sensors",
    "visualize",
]  # fmt: skip
