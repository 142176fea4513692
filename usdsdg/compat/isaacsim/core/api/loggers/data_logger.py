"""`DataLogger`: keeps what a function of the script returns at each step of the world."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from usdsdg.compat.isaacsim.core.utils.types import DataFrame

_KEY = "Isaac Sim Data"  # of the frames in the file, as there


class DataLogger:
    """Frames of data with the step and the time at which they were measured; it is paused until `start`."""

    def __init__(self) -> None:
        self._frames: list[DataFrame] = []
        self._started = False
        self._measure: Callable[..., dict[str, Any]] | None = None

    def add_data_frame_logging_func(self, func: Callable[..., dict[str, Any]]) -> None:
        """Keep what `func(tasks=..., scene=...)` returns at each step of the world while the logger is started."""
        self._measure = func

    def add_data(self, data: dict[str, Any], current_time_step: float, current_time: float) -> None:
        """Keep `data` of a step, at a time [s], unless the logger is paused."""
        if self._started:
            self._frames.append(DataFrame(int(current_time_step), current_time, data))

    def measure(self, tasks: dict[str, Any], scene: Any, current_time_step: int, current_time: float) -> None:
        """Keep what the script's function returns for this step, unless the logger is paused.

        Raises:
            RuntimeError: it is started, and no function was added.
        """
        if not self._started:
            return
        if self._measure is None:
            raise RuntimeError("the data logger was started; tell it what to keep: add_data_frame_logging_func(func)")
        self.add_data(self._measure(tasks=tasks, scene=scene), current_time_step, current_time)

    def start(self) -> None:
        self._started = True

    def pause(self) -> None:
        self._started = False

    def is_started(self) -> bool:
        return self._started

    def reset(self) -> None:
        """Pause, and forget the frames."""
        self._started, self._frames = False, []

    def get_num_of_data_frames(self) -> int:
        return len(self._frames)

    def get_data_frame(self, data_frame_index: int) -> DataFrame:
        return self._frames[data_frame_index]

    def save(self, log_path: str) -> None:
        """Write the frames as JSON."""
        frames = [frame.get_dict() for frame in self._frames]
        Path(log_path).write_text(json.dumps({_KEY: frames}), encoding="utf-8")

    def load(self, log_path: str) -> None:
        """Pause, and replace the frames with those of a file that `save` wrote."""
        frames = json.loads(Path(log_path).read_text(encoding="utf-8"))[_KEY]
        self._started, self._frames = False, [DataFrame.init_from_dict(each) for each in frames]
