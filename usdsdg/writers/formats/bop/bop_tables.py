"""The JSON files of a BOP dataset: the tables of a scene, and those of models and camera."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from functools import partial
from typing import Any

from usdsdg.writers.aggregate import Aggregate, Texts
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.formats.bop import bop_files as files
from usdsdg.writers.spool import Records

TABLES = (files.CAMERAS, files.POSES, files.INFOS)


class Scene(Aggregate):
    """The tables of one scene. A record has the "number" of a picture, and what each table has of it."""

    def __init__(self, backend: BaseBackend, split: str, number: int, place: int) -> None:
        """split: the folder of its folder. number: of the scene. place: which it is of its render product."""
        self.folder, self.place = files.scene_folder(split, number), place
        super().__init__(backend, f"BopWriter/{self.folder}")
        self.note(folder=self.folder)

    @staticmethod
    def files(records: Records) -> dict[str, Texts]:
        folder = records.about["folder"]
        return {files.table_of(folder, name): partial(_table, records, name) for name in TABLES}


class ModelTables(Aggregate):
    """`models_info.json` and `camera.json`. A record has the "id" and "info" of a model; "camera" is known of all."""

    @staticmethod
    def files(records: Records) -> dict[str, Texts]:
        camera = json.dumps(records.about["camera"], indent=1)
        return {files.MODELS_INFO: partial(_models_info, records), files.CAMERA: lambda: [camera]}


def _table(records: Records, name: str) -> Iterator[str]:
    return _object((each["number"], each[name]) for each in records)


def _models_info(records: Records) -> Iterator[str]:
    return _object(sorted((each["id"], each["info"]) for each in records))


def _object(members: Iterable[tuple[int, Any]]) -> Iterator[str]:
    """Yield the JSON object of members, as `json.dumps` with an indent of 1 writes it."""
    before = "{"
    for key, value in members:
        yield f"{before}\n " + f'"{key}": {json.dumps(value, indent=1)}'.replace("\n", "\n ")
        before = ","
    yield "{}" if before == "{" else "\n}"
