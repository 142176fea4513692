"""The end of a run: missing assets that were not reported yet, errors that the script caught, and remarks."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from usdsdg.cli.options.command_context import ReachedEnd


@contextmanager
def reported_outcome(*, caught_code: int = 1) -> Iterator[None]:
    """Run the body, then say what its author should know.

    Raises:
        MissingAssets: assets were missing, and the body did not end with this error.
        ReachedEnd: with `caught_code`, since the script caught an error of a writer, of physics or of an asset.
    """
    from usdsdg.errors import take_swallowed
    from usdsdg.session.remarks import remarks
    from usdsdg.stage import assets

    try:
        yield
    except assets.MissingAssets:
        raise
    except Exception:
        _print_missing()
        raise
    for remark in remarks():
        print(f"remark: {remark}", file=sys.stderr)
    swallowed = take_swallowed()
    assets.raise_missing()
    if swallowed:
        count = f"{len(swallowed)} errors" if len(swallowed) > 1 else "an error"
        first = "; the first" if len(swallowed) > 1 else ""
        print(
            f"error: the script caught {count} and went on, so something is missing from what it left{first}: "
            f"{' '.join(swallowed[0].split())} (--lenient ends with code 0)",
            file=sys.stderr,
        )
        raise ReachedEnd(caught_code)


def _print_missing() -> None:
    """Print the assets that were missing before the script failed, since they may be why."""
    from usdsdg.stage import assets

    if missing := assets.missing_assets():
        print(f"error: {assets.listed(missing)}", file=sys.stderr)
