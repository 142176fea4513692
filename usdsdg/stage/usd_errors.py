"""Text of USD errors, for messages of our own errors."""

from pxr import Tf


def reason(failure: Tf.ErrorException) -> str:
    """Return the message of a pxr error, without its source positions."""
    try:
        return "; ".join(error.commentary.strip() for error in failure.args) or str(failure)
    except UnicodeDecodeError:  # pxr quotes what it could not read
        return "it has bytes that are no UTF-8 text"
