"""What Pillow raises of images that it cannot decode."""

import struct

from PIL import Image, UnidentifiedImageError

# Decoders raise nearly anything of damaged files, and RuntimeError or NotImplementedError of kinds that are not read.
UNREADABLE = (
    OSError, ValueError, SyntaxError, EOFError, RuntimeError, TypeError, LookupError, ArithmeticError, struct.error,
    Image.DecompressionBombError,
)  # fmt: skip


def why_unreadable(error: Exception) -> str:
    """Return what an error of Pillow says, also of a file that is no image, where it names an object of Python."""
    return "it is no image of a format that is read" if isinstance(error, UnidentifiedImageError) else str(error)
