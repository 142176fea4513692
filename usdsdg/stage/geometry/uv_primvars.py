"""Names of the primvars that hold texture coordinates."""

# Those in use, tried in this order where a material names none that there is.
UV_NAMES = ("st", "st0", "st_0", "UVMap", "map1", "uv", "st1", "UVW")


def uv_candidates(name: str) -> tuple[str, ...]:
    """Return the primvars that may hold what a material reads by a name, or by none (""), likeliest first."""
    return (*_spellings(name), *UV_NAMES) if name and name not in UV_NAMES[:1] else UV_NAMES


def _spellings(name: str) -> tuple[str, ...]:
    """Return a name with and without an underscore before its number: exporters call the second set st1 or st_1."""
    stem = name.rstrip("0123456789")
    number = name[len(stem) :]
    other = stem[:-1] if stem.endswith("_") else f"{stem}_"
    return (name, other + number) if number and stem.strip("_") else (name,)
