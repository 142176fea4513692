"""What a command tells of failures: each cause once, although many files may fail by it."""

from __future__ import annotations

import sys

from usdsdg.errors import UsdsdgError, described
from usdsdg.session.session import current


def tell(error: UsdsdgError, when: str = "") -> None:
    """Print an error to stderr, unless one of the same cause was printed.

    when: what the program did then, such as "at the end of the run: ".
    """
    told = current().told_causes
    if error.cause in told:
        return
    if error.cause:
        told.add(error.cause)
    print(f"error: {when}{described(error)}", file=sys.stderr)
