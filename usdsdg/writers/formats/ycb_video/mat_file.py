"""MATLAB files of version 5, the same bytes for the same values."""

import io
from collections.abc import Mapping
from typing import Any

# scipy's header has the time and the platform in its text, of 116 bytes.
_TEXT = b"MATLAB 5.0 MAT-file, written by usdsdg".ljust(116)


def mat_file(values: Mapping[str, Any]) -> bytes:
    """Return a file with these arrays, by name; vectors are rows."""
    from scipy.io import savemat

    buffer = io.BytesIO()
    savemat(buffer, dict(values))
    return _TEXT + buffer.getvalue()[len(_TEXT) :]
