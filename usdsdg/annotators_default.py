"""The names of the built-in annotators (`rep.annotators_default`)."""

from usdsdg.annotators import get_registered_annotators

# In the order of `annotators.get_registered_annotators()`.
DEFAULT_ANNOTATORS: tuple[str, ...] = tuple(get_registered_annotators())

__all__ = ["DEFAULT_ANNOTATORS"]
