"""Lists of names in warnings."""


def listed(names: list[str]) -> str:
    """Return names for a sentence: five of them, and how many more there are."""
    return ", ".join(names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")
