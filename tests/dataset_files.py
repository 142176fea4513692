"""The files of a dataset, without what usdsdg notes about it in `.usdsdg`."""

from pathlib import Path

from usdsdg.stage.semantics.semantic_classes import BESIDE


def data_files(folder: str | Path) -> list[Path]:
    """Return the paths of a dataset's own files, sorted."""
    root = Path(folder)
    return sorted(path for path in root.rglob("*") if path.is_file() and BESIDE not in path.relative_to(root).parts)


def data_names(folder: str | Path) -> list[str]:
    """Return the paths of a dataset's own files relative to its folder, sorted."""
    return sorted(str(path.relative_to(folder)) for path in data_files(folder))
