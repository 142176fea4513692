"""BasicWriter's files of annotators beyond Replicator's: of whole objects, points and correspondence."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from usdsdg.datasets.folder import Folder
from usdsdg.datasets.formats.basic_arrays import array_of
from usdsdg.datasets.seen import Seen

BOXES = ("bounding_box_2d_amodal", "oriented_bounding_box_2d", "oriented_bounding_box_2d_amodal")
ROWS = ("visibility", "truncation", "keypoints")
MASKS, COORDINATES = "amodal_instance_segmentation", "object_coordinates"
CORRESPONDENCE = "dense_correspondence"
KINDS = (*BOXES, *ROWS, MASKS, COORDINATES, CORRESPONDENCE)
OWN = "own"  # in `Seen.extra`


class OwnFiles(NamedTuple):
    """The files of one annotator; None is what there is no file of, or what cannot be read."""

    kind: str
    filter: str
    file: str  # of the array; of masks that of the table
    values: np.ndarray | None
    table_file: str  # of what the annotation says beside its array
    table: Mapping[str, Any] | None
    paths_file: str
    paths: list[Any] | None
    picture_file: str
    picture: np.ndarray | None


def read_own(folder: Folder, seen: Seen, parts: Mapping[str, str], default_filter: str) -> None:
    """Add the files of an image to what is seen, by kind."""
    found = {}
    for kind in KINDS:
        array, picture = parts.get(f"{kind}/npy"), parts.get(f"{kind}/png") or parts.get(f"{kind}_visibility/png")
        table = parts.get(f"{kind}/info/json") or parts.get(f"{kind}/labels/json")
        paths = parts.get(f"{kind}/prim_paths/json")
        if array is None and (table is None or kind != MASKS):
            continue
        found[kind] = OwnFiles(
            kind,
            seen.truth.filter_of(kind, default_filter) if seen.truth else default_filter,
            array or table or "",
            array_of(folder, seen, array, kind) if array else None,
            table or "",
            folder.mapping(table, seen.name) if table else None,
            paths or "",
            folder.rows(paths, seen.name) if paths else None,
            picture or "",
            folder.image(picture, seen.name) if picture else None,
        )
    if found:
        seen.extra[OWN] = found
