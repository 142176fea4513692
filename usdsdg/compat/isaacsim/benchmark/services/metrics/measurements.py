"""`isaacsim.benchmark.services.metrics.measurements`: the records of a phase, and their JSON."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any


@dataclass
class Measurement:
    """A measurement with a name."""

    name: str


@dataclass
class SingleMeasurement(Measurement):
    """One number or word, with its unit."""

    value: float | int | str
    unit: str
    type: str = "single"


@dataclass
class BooleanMeasurement(Measurement):
    """A yes or no."""

    bvalue: bool
    type: str = "boolean"


@dataclass
class DictMeasurement(Measurement):
    """Values by name."""

    value: dict[str, Any]
    type: str = "dict"


@dataclass
class ListMeasurement(Measurement):
    """A list of samples; its representation has their number only."""

    value: list[Any]
    type: str = "list"

    def __repr__(self) -> str:
        return f"{type(self).__name__}(name={self.name!r}, length={len(self.value)})"


@dataclass
class MetadataBase:
    """A circumstance of the measurements, with a name."""

    name: str


@dataclass
class StringMetadata(MetadataBase):
    """A word."""

    data: str
    type: str = "string"


@dataclass
class IntMetadata(MetadataBase):
    """A whole number."""

    data: int
    type: str = "int"


@dataclass
class FloatMetadata(MetadataBase):
    """A number."""

    data: float
    type: str = "float"


@dataclass
class DictMetadata(MetadataBase):
    """Values by name."""

    data: dict[str, Any]
    type: str = "dict"


AnyMetadata = StringMetadata | IntMetadata | FloatMetadata | DictMetadata
# By the exact type of the data; metadata of other types, such as bool and None, is left out, as in Isaac Sim.
_METADATA: dict[type, Any] = {str: StringMetadata, int: IntMetadata, float: FloatMetadata, dict: DictMetadata}


@dataclass
class TestPhase:
    """The measurements and metadata of one phase."""

    __test__ = False  # not a test of pytest

    phase_name: str
    measurements: list[Measurement] = field(default_factory=list)
    metadata: list[AnyMetadata] = field(default_factory=list)

    def get_metadata_field(self, name: str, default: Any = KeyError) -> Any:
        """Return the data of a metadata entry; its name is compared in any case, without the name of the phase.

        Raises:
            KeyError: there is none and no `default` is given.
        """
        for entry in self.metadata:
            if entry.name.replace(self.phase_name, "").strip().lower() == name.lower():
                return entry.data
        if default is KeyError:
            raise KeyError(name)
        return default

    @classmethod
    def metadata_from_dict(cls, m: dict[str, Any]) -> list[AnyMetadata]:
        """Return the entries {"name": ..., "data": ...} of m["metadata"] whose data is a word, number or dict."""
        return [
            _METADATA[type(entry["data"])](name=entry["name"], data=entry["data"])
            for entry in m["metadata"]
            if type(entry.get("data")) in _METADATA
        ]

    @classmethod
    def from_json(cls, m: dict[str, Any]) -> TestPhase:
        """Return the phase that `TestPhaseEncoder` wrote."""
        measurements = [found for entry in m["measurements"] if (found := _measurement(entry)) is not None]
        return cls(m["phase_name"], measurements, cls.metadata_from_dict(m))

    @classmethod
    def aggregate_json_files(cls, json_folder_path: str | Path) -> list[TestPhase]:
        """Return the phases of all files `metrics*.json` of a folder, in the order of their names.

        Raises:
            json.JSONDecodeError: a file is not JSON.
        """
        files = sorted(Path(json_folder_path).glob("metrics*.json"))
        return [cls.from_json(phase) for file in files for phase in json.loads(file.read_text(encoding="utf-8"))]


def _measurement(entry: dict[str, Any]) -> Measurement | None:
    if "bvalue" in entry:
        return BooleanMeasurement(entry["name"], entry["bvalue"])
    value = entry.get("value")
    if isinstance(value, dict):
        return DictMeasurement(entry["name"], value)
    if isinstance(value, list):
        return ListMeasurement(entry["name"], value)
    return None if value is None else SingleMeasurement(entry["name"], value, entry.get("unit", ""))


class TestPhaseEncoder(json.JSONEncoder):
    """Writes phases, measurements and metadata as their fields."""

    __test__ = False

    def default(self, o: object) -> dict[str, Any]:
        return vars(o)
