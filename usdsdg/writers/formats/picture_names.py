"""Names of the files of a frame, for formats that number pictures."""


def stem_of(product: str, frame: int, padding: int, *, several: bool) -> str:
    """Return the name of a frame's files; that of the render product is in it where there are several."""
    return (f"{product}_" if several else "") + f"{frame:0{padding}d}"
