"""The AOVs of the renderer, by name."""

from collections.abc import Collection, Mapping

from usdsdg.errors import RenderError
from usdsdg_render.kernels.labels import aov_table, label_kernels

# Type, shape and miss value of each; the docstrings of the functions in kernels/labels describe them.
AOVS: Mapping[str, aov_table.Aov] = label_kernels.AOVS


def check_names(names: Collection[str]) -> tuple[str, ...]:
    """Return the names in the order of the table.

    Raises:
        RenderError: a name is not in the table.
    """
    unknown = sorted(set(names) - AOVS.keys())
    if unknown:
        raise RenderError(f"no such AOV: {', '.join(unknown)}. There are: {', '.join(AOVS)}.")
    return tuple(name for name in AOVS if name in names)
