"""What USD says when it fails, as part of a message of ours."""

from pxr import Tf


def reason(failure: Tf.ErrorException) -> str:
    """What pxr said, without its source positions."""
    return "; ".join(error.commentary.strip() for error in failure.args) or str(failure)
