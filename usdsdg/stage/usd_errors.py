"""USD errors as text for messages of our own errors, and as errors of the system."""

from pxr import Pcp, Sdf, Tf


def reason(failure: Tf.ErrorException) -> str:
    """Return the message of a pxr error, without its source positions, and with each of its causes once."""
    try:
        texts = [error.commentary.strip() for error in failure.args]
    except UnicodeDecodeError:  # pxr quotes what it could not read
        return "it has bytes that are no UTF-8 text"
    # Of a disk that is full there is an error for each block that could not be written.
    causes = [text for number, text in enumerate(texts) if not any(first in text for first in texts[:number])]
    return "; ".join(causes) or str(failure)


def text_of(error: Pcp.ErrorBase) -> str:
    """Return the message of an error of composition, which may quote bytes of a file that are no UTF-8 text."""
    try:
        return str(error)
    except UnicodeDecodeError as undecoded:
        return undecoded.object.decode(errors="replace")


def save(layer: Sdf.Layer) -> None:
    """Save a layer to its file.

    Raises:
        OSError: it cannot be written, as on a full disk.
    """
    try:
        layer.Save()
    except Tf.ErrorException as failure:
        raise OSError(reason(failure)) from failure
