"""The global seed of the run, which metadata.txt and the ids of some formats record."""

from usdsdg.session.session import current


def set_global_seed(seed: int | None) -> None:
    """Set the seed of the latest captured frame."""
    current().metadata_seed = seed


def global_seed() -> int | None:
    """Return the seed of the run; None before its first frame."""
    return current().metadata_seed
