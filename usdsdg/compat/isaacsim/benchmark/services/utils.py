"""`isaacsim.benchmark.services.utils`: logging, the version, and waiting for a stage."""

from __future__ import annotations

import logging
from importlib import metadata
from pathlib import Path

from usdsdg.app.app import get_app

__all__ = [
    "ensure_dir", "get_kit_version_branch", "set_up_logging", "wait_until_stage_is_fully_loaded",
    "wait_until_stage_is_fully_loaded_async",
]  # fmt: skip


def set_up_logging(name: str) -> logging.Logger:
    """Return the logger of a module, with the handlers of the process."""
    return logging.getLogger(name)


def ensure_dir(file_path: str | Path) -> None:
    """Create a folder and its parents where they are missing."""
    Path(file_path).mkdir(parents=True, exist_ok=True)


def get_kit_version_branch() -> tuple[str, str, str]:
    """Return (version, name, both): usdsdg's own, in place of Kit's version and branch."""
    version = metadata.version("usdsdg")
    return version, "usdsdg", f"{version}_usdsdg"


def wait_until_stage_is_fully_loaded(
    max_frames: int = 10, frametime_threshold: float = 0.1, time_ratio_treshold: float = 5
) -> None:
    """Run one app update: stages and materials are loaded when they are opened."""
    get_app().update()


async def wait_until_stage_is_fully_loaded_async(
    max_frames: int = 10, frametime_threshold: float = 0.1, time_ratio_treshold: float = 5
) -> None:
    """Wait for one app update: stages and materials are loaded when they are opened."""
    await get_app().next_update_async()
