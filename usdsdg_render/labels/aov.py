"""The AOVs that the renderer has, by name."""

from collections.abc import Collection, Mapping

from usdsdg.errors import RenderError
from usdsdg_render.kernels.labels import aov_table, label_kernels

# Type, shape and value for a miss of each; the functions of the table say what they mean.
AOVS: Mapping[str, aov_table.Aov] = label_kernels.AOVS


def check_names(names: Collection[str]) -> tuple[str, ...]:
    """The names in the order of the table.

    Raises:
        RenderError: a name is not in the table.
    """
    unknown = sorted(set(names) - AOVS.keys())
    if unknown:
        raise RenderError(f"no such AOV: {', '.join(unknown)}. There are: {', '.join(AOVS)}.")
    return tuple(name for name in AOVS if name in names)
