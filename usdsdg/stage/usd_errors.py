"""Text of USD errors, for messages of our own errors."""

from pxr import Tf


def reason(failure: Tf.ErrorException) -> str:
    """Return the message of a pxr error, without its source positions."""
    return "; ".join(error.commentary.strip() for error in failure.args) or str(failure)
