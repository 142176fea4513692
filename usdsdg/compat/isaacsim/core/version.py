"""`isaacsim.core.version`: the version of Isaac Sim whose interfaces these are."""

from __future__ import annotations

from dataclasses import dataclass

# The newest version whose scripts are run as they are.
MIRRORED = "6.0.1"


@dataclass
class Version:
    """The parts of a version such as "4.5.0-rc.36+release": texts, empty where there is none."""

    core: str = ""
    prerelease: str = ""
    major: str = ""
    minor: str = ""
    patch: str = ""
    pretag: str = ""
    prebuild: str = ""
    buildtag: str = ""


def parse_version(full_version: str) -> Version:
    """Split a version, "core-tag.build+buildtag", into its parts."""
    rest, _, buildtag = full_version.partition("+")
    core, _, prerelease = rest.partition("-")
    major, minor, patch = (*core.split(".", 2), "", "")[:3]
    pretag, _, prebuild = prerelease.partition(".")
    return Version(core, prerelease, major, minor, patch, pretag, prebuild, buildtag)


def get_version() -> tuple[str, str, str, str, str, str, str, str]:
    """Return core, prerelease, major, minor, patch, tag and number of the prerelease, and build tag."""
    found = parse_version(MIRRORED)
    return (
        found.core, found.prerelease, found.major, found.minor, found.patch, found.pretag, found.prebuild,
        found.buildtag,
    )  # fmt: skip
