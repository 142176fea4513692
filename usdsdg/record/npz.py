"""Arrays by name as the bytes of a compressed .npz, the same bytes for the same arrays; `numpy.load` opens them."""

import io
import zipfile
from collections.abc import Mapping

import numpy as np

# The earliest that the format knows: a file must not depend on when it was written.
_DATE = (1980, 1, 1, 0, 0, 0)


def encode(arrays: Mapping[str, np.ndarray], *, level: int = 4) -> bytes:
    """Return the bytes of the file."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=level) as archive:
        for name, array in arrays.items():
            member = zipfile.ZipInfo(f"{name}.npy", _DATE)
            member.compress_type = zipfile.ZIP_DEFLATED
            content = io.BytesIO()
            np.lib.format.write_array(content, np.ascontiguousarray(array), allow_pickle=False)
            archive.writestr(member, content.getvalue(), compresslevel=level)
    return file.getvalue()


def decode(data: bytes) -> dict[str, np.ndarray]:
    """Return the arrays.

    Raises:
        ValueError, OSError, zipfile.BadZipFile: `data` are not those of a .npz, or damaged.
    """
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        return dict(arrays)
