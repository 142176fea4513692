"""The ids of a segmentation: what they stand for until a label changes, and what a frame shows of them."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from usdsdg.annotators.base import predicate_of
from usdsdg.annotators.colors import BACKGROUND, UNLABELLED, colors_of_ids
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.kinds.id_mapping import Chosen, read_mapping, warn_of_shared_ids
from usdsdg.annotators.pixels.look_up_table import LookUpTable
from usdsdg.annotators.selection import Selection


@dataclass(frozen=True, eq=False)
class Ids:
    """The ids of a segmentation and what they stand for, in all frames until a label changes."""

    of_entries: np.ndarray  # (G + 1,) uint32: of each gprim, and of pixels without a hit
    tables: Mapping[str, Sequence[Any]]  # of annotators' info, by id
    keys: Callable[[], Sequence[Sequence[str]]]  # by id, those that a mapping may have; its first one applies
    always: tuple[int, ...] = (BACKGROUND, UNLABELLED)  # listed whether or not they are in the picture
    own_colors: Mapping[int, tuple[int, ...]] = field(default_factory=dict)  # RGBA that the user has given, by id

    @cached_property
    def table(self) -> LookUpTable:
        """The id of each entry."""
        return LookUpTable(self.of_entries, is_of_all=True)

    @cached_property
    def colors(self) -> LookUpTable:
        """The color of each entry, (G + 1, 4) uint8."""
        return LookUpTable(self.known_colors[self._places], is_of_all=True)

    @cached_property
    def known(self) -> np.ndarray:
        """All ids that there are, int64 (N,), in order."""
        return np.union1d(self.of_entries.astype(np.int64), np.array(self.always, np.int64))

    @cached_property
    def known_colors(self) -> np.ndarray:
        """The colors of all ids that there are, (N, 4) uint8."""
        return self.colors_of(self.known)

    def colors_of(self, ids: np.ndarray) -> np.ndarray:
        """Return the colors of ids (N, 4) uint8: those of the user, else the usual ones."""
        colors = colors_of_ids(ids)
        for id_, color in self.own_colors.items():
            colors[ids == id_] = color
        return colors

    def are_present(self, frame: Frame) -> np.ndarray:
        """Return which of the known ids are in the picture, bool (N,)."""
        are_in = np.zeros(len(self.known), bool)
        are_in[self._places[frame.shown_gprims]] = True
        are_in[self._places[-1]] |= frame.shows_background
        return are_in

    @cached_property
    def are_always_listed(self) -> np.ndarray:
        """Which of the known ids tables list whether or not they are in the picture, bool (N,)."""
        return np.isin(self.known, self.always)

    @cached_property
    def _places(self) -> np.ndarray:
        return np.searchsorted(self.known, self.of_entries)


@dataclass(frozen=True, eq=False)
class Shown:
    """The ids that a segmentation shows in one frame, and what they stand for."""

    table: LookUpTable  # (G + 1,) uint32: of each gprim, and of pixels without a hit
    find_colors: Callable[[], LookUpTable]
    tables: Mapping[str, Sequence[Any]]  # of annotators' info, by the id before the mapping
    listed: np.ndarray  # (N,): ids that the tables list
    meanings: np.ndarray  # (N,): the id of each before the mapping
    listed_colors: np.ndarray  # (N, 4) uint8

    @property
    def ids(self) -> np.ndarray:
        """The id of each gprim, and of pixels without a hit, (G + 1,) uint32."""
        return self.table.values

    @cached_property
    def colors(self) -> LookUpTable:
        """The color of each gprim in the picture, and of pixels without a hit, (G + 1, 4) uint8."""
        return self.find_colors()


def shown_ids(frame: Frame, params: Mapping[str, Any], find: Callable[[Frame, Selection], Ids]) -> Shown:
    """Return the ids that a function finds as a frame shows them; annotators that differ in what they show share it."""
    mapping = params["mapping"]
    selection = frame.selection(predicate_of(params))
    ids = selection.keep(find, lambda: find(frame, selection))
    key = (ids, json.dumps(mapping, sort_keys=True, default=str) if mapping else None)
    return frame.derive(key, lambda: _mapped(frame, ids, read_mapping(mapping)) if mapping else _unmapped(frame, ids))


def _unmapped(frame: Frame, ids: Ids) -> Shown:
    """List the ids that are in the picture, as they are."""
    are_listed = ids.are_present(frame) | ids.are_always_listed
    listed = ids.known[are_listed]
    return Shown(ids.table, lambda: ids.colors, ids.tables, listed, listed, ids.known_colors[are_listed])


def _mapped(frame: Frame, ids: Ids, chosen_by_key: Mapping[str, Chosen]) -> Shown:
    """Apply a mapping of the user to ids, and list those that are in the picture."""
    known = ids.keys()
    new_id = np.arange(len(known), dtype=np.uint32)
    mapped: dict[int, int] = {}
    chosen: dict[int, tuple[int, ...]] = {}
    for index, names in enumerate(known):
        value = next((chosen_by_key[name] for name in names if name in chosen_by_key), None)
        if isinstance(value, int):
            new_id[index] = mapped[index] = value
        elif value is not None:
            chosen[index] = value
    warn_of_shared_ids(known, mapped)
    # Of several old ids with the same new id, the first that is visible represents all.
    old_id: dict[int, int] = {}
    for old in (*ids.known[ids.are_present(frame)].tolist(), *ids.always):
        old_id.setdefault(int(new_id[old]), old)
    listed = np.array(sorted(old_id), np.int64)
    meanings = np.array([old_id[i] for i in listed.tolist()], np.int64)
    colors = np.where((listed == meanings)[:, None], ids.colors_of(listed), colors_of_ids(listed))
    for index, color in chosen.items():
        colors[listed == new_id[index]] = color
    of_entries = new_id[ids.of_entries]
    return Shown(
        LookUpTable(of_entries), lambda: _palette(of_entries, listed, colors), ids.tables, listed, meanings, colors
    )


def _palette(of_entries: np.ndarray, listed: np.ndarray, colors: np.ndarray) -> LookUpTable:
    """Return the color of each entry whose id is listed; zeros for others, which no pixel shows."""
    places = np.searchsorted(listed, of_entries)
    places[places == len(listed)] = 0
    found = colors[places]
    found[listed[places] != of_entries] = 0
    return LookUpTable(found)
