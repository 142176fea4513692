"""Text that a terminal shows as it is: names of files and labels may have any characters."""


def printable(text: str) -> str:
    """Return a text with escapes for what is not printed: ends of lines, codes of terminals, half characters."""
    return "".join(each if each.isprintable() else each.encode("unicode_escape").decode("ascii") for each in text)
