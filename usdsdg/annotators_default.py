"""The annotators that are registered from the start (`rep.annotators_default`)."""

from usdsdg.annotators import get_registered_annotators

# In the order in which `annotators.get_registered_annotators()` tells them.
DEFAULT_ANNOTATORS: tuple[str, ...] = tuple(get_registered_annotators())

__all__ = ["DEFAULT_ANNOTATORS"]
