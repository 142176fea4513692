"""`isaacsim.test.utils.file_validation`: numbers of files, which Isaac Sim's examples check with `--test`."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

from usdsdg.errors import counted
from usdsdg.stage.semantics.semantic_classes import BESIDE

__all__ = ["get_folder_file_summary", "validate_folder_contents"]


def validate_folder_contents(
    path: str | Path,
    expected_counts: dict[str, int],
    *,
    recursive: bool = False,
    fail_on_empty_files: bool = False,
    allowed_extra_extensions: set[str] | None = None,
    min_file_size_bytes: int = 0,
    exact_match: bool = True,
) -> bool:
    """Return whether a folder has the expected number of files of each extension ("png": 3); print each mismatch.

    Args:
        expected_counts: Number of files by extension without its dot, in any case.
        allowed_extra_extensions: Other extensions that are allowed; None allows all.
        min_file_size_bytes: Smaller files are mismatches.
        exact_match: False also allows more files of an expected extension.
    """
    folder = Path(path)
    if not folder.is_dir():
        print(f"validate_folder_contents: {folder} is not a folder")
        return False
    files = _files(folder, recursive)
    least = max(min_file_size_bytes, 1 if fail_on_empty_files else 0)
    wrong = [f"{each} has {each.stat().st_size} bytes" for each in files if each.stat().st_size < least]
    found = Counter(each.suffix.lstrip(".").lower() for each in files)
    expected = {extension.lstrip(".").lower(): count for extension, count in expected_counts.items()}
    for extension, count in expected.items():
        fits = found[extension] == count if exact_match else found[extension] >= count
        if not fits:
            wrong.append(f"{counted(found[extension], 'file')} .{extension} instead of {count}")
    if allowed_extra_extensions is not None:
        allowed = {extension.lstrip(".").lower() for extension in allowed_extra_extensions} | set(expected)
        wrong += [f"files .{extension}, which are not allowed" for extension in sorted(set(found) - allowed)]
    for each in wrong:
        print(f"validate_folder_contents: {folder}: {each}")
    return not wrong


def get_folder_file_summary(
    path: str | Path, *, recursive: bool = False, include_file_sizes: bool = False
) -> dict[str, Any]:
    """Return "total_files" and "extension_counts" {"png": 3} of a folder; zeros where there is none.

    With `include_file_sizes` also "file_details": for each extension a list of {"path", "size_bytes"}, sorted by path.
    """
    folder = Path(path)
    files = _files(folder, recursive) if folder.is_dir() else []
    named = [each for each in files if each.suffix]
    counts = Counter(_extension(each) for each in named)
    summary: dict[str, Any] = {"total_files": len(files), "extension_counts": dict(counts)}
    if include_file_sizes:
        details: dict[str, list[dict[str, str | int]]] = {extension: [] for extension in counts}
        for each in named:
            details[_extension(each)].append({"path": str(each), "size_bytes": each.stat().st_size})
        summary["file_details"] = details
    return summary


def _files(folder: Path, recursive: bool) -> list[Path]:
    """Return the files of a folder, sorted, without those that only usdsdg keeps beside a dataset."""
    found = sorted(folder.rglob("*") if recursive else folder.glob("*"))
    return [each for each in found if each.is_file() and BESIDE not in each.relative_to(folder).parts]


def _extension(file: Path) -> str:
    return file.suffix[1:].lower()
