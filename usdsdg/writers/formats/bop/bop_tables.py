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

    @staticmethod
    def files(records: Records) -> dict[str, Texts]:
        folder = records.about["folder"]
        return {files.table_of(folder, name): partial(_table, records, name) for name in TABLES}


class ModelTables(Aggregate):
    """`models_info.json` and `names.json`, of the models that are seen, and `camera.json`.

    A record has the ids of the "models" that a frame shows, and the "camera" of its first picture. Of all frames are
    known the "infos" and "names" of all models by id.
    """

    @staticmethod
    def files(records: Records) -> dict[str, Texts]:
        return {
            files.MODELS_INFO: partial(_models, records, "infos"),
            files.MODEL_NAMES: partial(_models, records, "names"),
            files.CAMERA: partial(_camera, records),
        }


def _table(records: Records, name: str) -> Iterator[str]:
    return _object((each["number"], each[name]) for each in records)


def _models(records: Records, what: str) -> Iterator[str]:
    """Yield the JSON object of what is known of the models that are seen, by id."""
    seen = sorted({obj_id for each in records for obj_id in each["models"]})
    return _object((obj_id, records.about[what][str(obj_id)]) for obj_id in seen)


def _camera(records: Records) -> Iterator[str]:
    yield json.dumps(next(iter(records))["camera"], indent=1)


def _object(members: Iterable[tuple[int, Any]]) -> Iterator[str]:
    """Yield the JSON object of members, as `json.dumps` with an indent of 1 writes it."""
    before = "{"
    for key, value in members:
        yield f"{before}\n " + f'"{key}": {json.dumps(value, indent=1)}'.replace("\n", "\n ")
        before = ","
    yield "{}" if before == "{" else "\n}"
