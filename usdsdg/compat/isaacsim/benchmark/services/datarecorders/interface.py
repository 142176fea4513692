"""`isaacsim.benchmark.services.datarecorders.interface`: what a recorder is, and the recorders by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from usdsdg.compat.isaacsim.benchmark.services.metrics.measurements import AnyMetadata, Measurement


@dataclass
class MeasurementData:
    """What a recorder found in a phase; artefacts are files with a label."""

    measurements: Sequence[Measurement] = field(default_factory=list)
    metadata: Sequence[AnyMetadata] = field(default_factory=list)
    artefacts: Sequence[tuple[Path, str]] = field(default_factory=list)


@dataclass
class InputContext:
    """What a benchmark tells its recorders; `phase` is the current one."""

    artifact_prefix: str = ""
    kit_version: str = ""
    phase: str = ""


class MeasurementDataRecorder:
    """A recorder: `get_data` ends a phase; `start_collecting` and `stop_collecting`, where there are such, frame it."""

    def __init__(self, context: InputContext | None = None, root_dir: Path | None = None) -> None:
        self.context = context

    def get_data(self) -> MeasurementData:
        """Return what has been found; nothing by default."""
        return MeasurementData()


RecorderType = TypeVar("RecorderType", bound=type[MeasurementDataRecorder])


class MeasurementDataRecorderRegistry:
    """The classes of recorders by name."""

    name_to_class: dict[str, type[MeasurementDataRecorder]] = {}

    @classmethod
    def add(cls, name: str, recorder: type[MeasurementDataRecorder]) -> None:
        """Register a class; it replaces an earlier one of that name."""
        cls.name_to_class[name] = recorder

    @classmethod
    def get(cls, name: str) -> type[MeasurementDataRecorder] | None:
        """Return the class of a name, None if there is none."""
        return cls.name_to_class.get(name)

    @classmethod
    def get_many(cls, names: list[str]) -> list[type[MeasurementDataRecorder]]:
        """Return the classes of those names that are registered."""
        return [cls.name_to_class[name] for name in names if name in cls.name_to_class]

    @classmethod
    def register(cls, name: str) -> Callable[[RecorderType], RecorderType]:
        """Register the decorated class."""

        def decorator(recorder_class: RecorderType) -> RecorderType:
            cls.add(name, recorder_class)
            return recorder_class

        return decorator

    @classmethod
    def list_available(cls) -> list[str]:
        """Return all registered names, oldest first."""
        return list(cls.name_to_class)
