"""Rerun, which is installed with `usdsdg[rerun]`."""

from typing import Any

from usdsdg.errors import Unsupported


def rerun() -> Any:
    """Return rerun with its module of chunks.

    Raises:
        Unsupported: it is not installed, or is too old to have chunks.
    """
    try:
        import rerun
        import rerun.chunk
    except ImportError as error:
        raise Unsupported(f"Rerun is not installed ({error}): pip install 'usdsdg[rerun]'.") from error
    return rerun
