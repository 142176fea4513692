"""The structured arrays of `omni.syntheticdata`."""

import numpy as np

# The first fields of a row about a labeled prim.
PRIM_FIELDS = [
    ("uniqueId", "<i4"), ("name", "O"), ("semanticLabel", "O"), ("metadata", "O"), ("instanceIds", "O"),
]  # fmt: skip
MAPPING = np.dtype(
    [
        ("uniqueId", "<i4"), ("name", "O"), ("semanticId", "<i4"), ("semanticLabel", "O"), ("instanceIds", "O"),
        ("metadata", "O"),
    ]
)  # fmt: skip
BOX_2D = np.dtype([("semanticId", "<u4"), ("x_min", "<i4"), ("y_min", "<i4"), ("x_max", "<i4"), ("y_max", "<i4")])
CORNER_NAMES = ("x_min", "y_min", "z_min", "x_max", "y_max", "z_max")
BOX_3D = np.dtype(
    [("instanceId", "<u4"), ("semanticId", "<u4"), *((name, "<f4") for name in CORNER_NAMES),
     ("transform", "<f4", (4, 4))]
)  # fmt: skip
OCCLUSION = np.dtype([("instanceId", "<u4"), ("semanticId", "<u4"), ("occlusionRatio", "<f4")])


def joined(*arrays: np.ndarray) -> np.ndarray:
    """Return an array with the fields of several structured arrays of the same length."""
    fields = [(name, array.dtype[name]) for array in arrays for name in array.dtype.names or ()]
    whole = np.empty(len(arrays[0]), fields)
    for array in arrays:
        for name in array.dtype.names or ():
            whole[name] = array[name]
    return whole
