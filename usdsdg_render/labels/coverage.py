"""The coverage pass on the host: bit-packed masks of the pixels that groups of gprims would cover alone.

A ray is not traced from one hit to the next: coincident faces of two instances lie at the same distance, so continuing
behind the first would skip the second. Instead, the ray is intersected with each instance separately, by the same tests
of the same triangles as when the instance is alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import warp as wp

from usdsdg.parallel import CUDA_BLOCK, launch_rows
from usdsdg.readback import read_back
from usdsdg.stage.geometry.pixel_masks import MASK_WORD, WORD_PIXELS, PixelMasks
from usdsdg_render.device.camera import camera_array
from usdsdg_render.device.device_scene import DeviceScene
from usdsdg_render.kernels.labels import coverage as kernels
from usdsdg_render.kernels.labels.coverage import BYTES, MaskWord
from usdsdg_render.kernels.labels.coverage_tiles import fill_words_by_tiles, tile_memory
from usdsdg_render.kernels.labels.screen_bounds import ANYWHERE, SIDES, bound_on_screen
from usdsdg_render.labels import lens_bounds
from usdsdg_render.labels.parts import DividedGprims

if TYPE_CHECKING:
    from usdsdg.stage.cameras.camera_view import CameraView

WORDS_PER_BAND = 1024
# Threads share the rows of an instance.
ROW_PARTS = 16
UNITS_PER_BAND = 16
# Initial sums of a group, of no pixels: pixels, x_min, y_min, x_max, y_max, visible pixels.
_NO_PIXELS = np.array([0, 1 << 30, 1 << 30, -1, -1, 0], np.int32)


class _Words(NamedTuple):
    """Words of masks on a device, ordered by image, owner, row and column."""

    words: wp.array  # MaskWord
    covered: wp.array  # uint64, a bit for each pixel
    visible: wp.array  # uint64


class Coverage:
    """Masks of groups of gprims in images of one size, computed in one launch.

    Args:
        views: cameras with images of one size.
        groups: entries of each group; gprim indices where no gprim is divided.
        shown: (views, height, width) int32, the entries that the same views show in the same mode.
        divided: the entries.
    """

    def __init__(
        self,
        device_scene: DeviceScene,
        views: Sequence[CameraView],
        groups: Sequence[Sequence[int]],
        shown: wp.array,
        divided: DividedGprims,
        *,
        mode: int,
        threads: int | None,
    ) -> None:
        self._scene, self._views, self._groups, self._divided = device_scene, views, len(groups), divided
        self._device, self._threads = device_scene.device, threads
        self._size = views[0].width, views[0].height
        self._cameras = camera_array(views, self._device)
        tested, members = _tested(groups, device_scene.placement.placed[divided.instances])
        # Of each tested entry; -1 for none.
        self._instances = np.append(divided.instances, -1)[tested]
        self._tested = self._array(tested, wp.int32)
        bounds = self._screen_bounds()
        words, counts, after = self._list_words(bounds)
        if self._device == "cpu" and not divided.are_there:
            self._words = self._fill_by_tiles(words, shown, mode, bounds, counts, after)
        else:
            self._words = self._fill_words(words, shown, mode)
        if members is not None:
            self._words = self._merge_groups(self._words, *members)

    def sums(self) -> np.ndarray:
        """Return the size and bounds of each mask.

        (views, groups, 6) int32: amodal pixels, x_min, y_min, x_max, y_max (inclusive; -1 for no pixels), modal pixels.
        """
        sums = self._array(np.tile(_NO_PIXELS, (len(self._views), self._groups, 1)), wp.int32)
        self._launch(kernels.sum_mask_words, len(self._words.words), [*self._words], [sums])
        result = sums.numpy()
        result[result[..., 0] == 0, 1:5] = -1
        return result

    def pixel_masks(self) -> list[PixelMasks]:
        """Return the masks of each image; their words stay on the device until they are read."""
        sums = self.sums().astype(np.int64)
        words = _HostWords(self._words)
        width, height = self._size
        return [
            PixelMasks((height, width), self._groups, partial(words.of, k), coverage=each[:, :5], visible=each[:, 5])
            for k, each in enumerate(sums)
        ]

    def _screen_bounds(self) -> wp.array:
        """Bound the pixels that instances can cover by 8-DOPs, (views, tested, SIDES) float32."""
        bounds = self._empty((len(self._views), len(self._instances), SIDES), wp.float32)
        instances = self._array(self._instances, wp.int32)
        inputs = [self._scene.tables, self._scene.supports, self._cameras, instances]
        self._rows(bound_on_screen, bounds.shape[:2], inputs, [bounds])
        for k, view in enumerate(self._views):
            if view.lens is not None and len(self._instances):
                wp.copy(bounds[k], self._array(self._lens_bounds(view), wp.float32))
        return bounds

    def _lens_bounds(self, view: CameraView) -> np.ndarray:
        """Return the screen bounds of one view with a lens model: rectangles, as 8-DOPs (tested, SIDES)."""
        present = self._instances >= 0
        bounds = np.full((len(present), SIDES), ANYWHERE)
        bounds[~present] = -ANYWHERE
        placement, instances = self._scene.placement, self._instances[present]
        world_boxes = (each[instances].astype(np.float64) for each in (placement.lower, placement.upper))
        rectangles = lens_bounds.bound_through_lens(view, *world_boxes)
        bounds[present, :2], bounds[present, 4:6] = rectangles[:, 2:], -rectangles[:, :2]
        return bounds

    def _list_words(self, bounds: wp.array) -> tuple[wp.array, wp.array, wp.array]:
        """List the mask words within screen bounds, without their bits.

        Returns:
            the words; (views, tested, parts): how many each part of the rows has, and the running sums of that.
        """
        shape = (*bounds.shape[:2], ROW_PARTS)
        counts, after = self._empty(shape, wp.int32), self._empty(shape, wp.int32)
        none = self._empty(0, MaskWord)
        inputs = [*self._size, bounds]
        self._rows(kernels.list_mask_words, shape, [*inputs, self._empty((0, 0, 0), wp.int32)], [counts, none])
        words = self._empty(_running_sums(counts, after), MaskWord)
        self._rows(kernels.list_mask_words, shape, [*inputs, after], [counts, words])
        return words, counts, after

    def _fill_by_tiles(
        self, words: wp.array, shown: wp.array, mode: int, bounds: wp.array, counts: wp.array, after: wp.array
    ) -> _Words:
        """Trace the pixels of listed words by tiles and set their bits, on a CPU."""
        covered, visible = (wp.zeros(len(words), dtype=wp.uint64, device="cpu") for _ in range(2))
        memory = tile_memory(-(-counts.size // UNITS_PER_BAND))
        inputs = [self._scene.tables, self._cameras, mode, shown, self._tested, bounds, counts, after, memory]
        inputs.append(UNITS_PER_BAND)
        outputs = [_bytes(covered), _bytes(visible)]
        self._rows(fill_words_by_tiles, (counts.size,), inputs, outputs, band_rows=UNITS_PER_BAND)
        return _Words(words, covered, visible)

    def _fill_words(self, words: wp.array, shown: wp.array, mode: int) -> _Words:
        """Trace the pixels of listed words and set their bits."""
        covered, visible = (self._empty(len(words), wp.uint64) for _ in range(2))
        # On a CPU a thread fills a whole word, on a GPU a byte of it.
        threads = 1 if self._device == "cpu" else BYTES
        parts = self._divided.record
        inputs = [self._scene.tables, self._cameras, mode, shown, parts, self._tested, words, BYTES // threads]
        shape = (len(words), threads)
        outputs = [_bytes(covered), _bytes(visible)]
        self._rows(self._divided.fill_kernel, shape, inputs, outputs, band_rows=WORDS_PER_BAND)
        return _Words(words, covered, visible)

    def _merge_groups(self, given: _Words, first_group: np.ndarray, groups_of: np.ndarray) -> _Words:
        """Merge the words of instances into words of their groups, so that each pixel counts once."""
        size, words = (self._groups, *self._size), given.words
        device_first, device_groups = self._array(first_group, wp.int32), self._array(groups_of, wp.int32)
        counts, after = (self._empty(len(words), wp.int32) for _ in range(2))
        self._launch(kernels.count_groups, len(words), [words, given.covered, device_first], [counts])
        copies = _running_sums(counts, after)
        # The radix sort needs arrays of twice the length.
        keys, sources = self._empty(2 * copies, wp.int64), self._empty(2 * copies, wp.int32)
        inputs = [words, after, counts, device_first, device_groups, *size]
        self._launch(kernels.copy_to_groups, len(words), inputs, [keys, sources])
        wp.utils.radix_sort_pairs(keys, sources, copies)
        marks, slots = self._empty(copies, wp.int32), self._empty(copies, wp.int32)
        self._launch(kernels.mark_first_of_key, copies, [keys], [marks])
        count = _running_sums(marks, slots)
        merged = _Words(*(self._empty(count, dtype) for dtype in (MaskWord, wp.uint64, wp.uint64)))
        self._launch(kernels.merge_mask_words, copies, [copies, keys, sources, slots, marks, *given, *size], [*merged])
        return merged

    def _array(self, values: np.ndarray, dtype: Any) -> wp.array:
        return wp.array(values, dtype=dtype, device=self._device)

    def _empty(self, shape: Any, dtype: Any) -> wp.array:
        return wp.empty(shape, dtype=dtype, device=self._device)

    def _rows(self, kernel: Any, shape: tuple[int, ...], inputs: list, outputs: list, *, band_rows: int = 1) -> None:
        launch_rows(kernel, shape, inputs, outputs, device=self._device, threads=self._threads, band_rows=band_rows)

    def _launch(self, kernel: Any, count: int, inputs: list, outputs: list) -> None:
        wp.launch(kernel, dim=count, inputs=inputs, outputs=outputs, device=self._device, block_dim=CUDA_BLOCK)


class _HostWords:
    """Mask words of all images on the host, copied once on first use."""

    def __init__(self, words: _Words) -> None:
        self._words: _Words | None = words
        self._rows = np.zeros(0, MASK_WORD)
        self._images = np.zeros(0, np.int32)

    def of(self, image: int) -> np.ndarray:
        """Return the rows of MASK_WORD of one image."""
        if self._words is not None:
            self._copy(self._words)
            self._words = None
        first, last = np.searchsorted(self._images, [image, image + 1])
        return self._rows[first:last]

    def _copy(self, words: _Words) -> None:
        copies = read_back(words._asdict())
        nonzero = np.flatnonzero(copies["covered"])
        found = copies["words"][nonzero]
        self._rows = np.zeros(len(nonzero), MASK_WORD)
        self._rows["group"], self._rows["row"] = found["owner"], found["row"]
        self._rows["word"] = found["first"] // WORD_PIXELS
        for name in ("covered", "visible"):
            self._rows[name] = copies[name][nonzero]
        self._images = found["image"]


def _tested(
    groups: Sequence[Sequence[int]], placed: np.ndarray
) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray] | None]:
    """Select the entries to test, and the groups that each of them belongs to.

    If no entry is in two groups and no group has two entries, the result is the entry of each group (or -1)
    and None. Else the second result is (first_group, groups): the groups of entry i are
    groups[first_group[i]:first_group[i + 1]], with i an index into the first result.
    """
    members = np.array([each for group in groups for each in group], np.int64)
    owners = np.repeat(np.arange(len(groups)), [len(group) for group in groups])
    members, owners = members[placed[members]], owners[placed[members]]
    tested = np.unique(members)
    if len(tested) == len(members) == len(np.unique(owners)):
        of_group = np.full(len(groups), -1, np.int64)
        of_group[owners] = members
        return of_group, None
    pairs = np.unique(np.stack([members, owners], axis=1), axis=0)
    return tested, (np.searchsorted(pairs[:, 0], np.append(tested, len(placed))), pairs[:, 1])


def _running_sums(counts: wp.array, sums: wp.array) -> int:
    """Fill `sums` with the inclusive running sums of `counts`, and return the total."""
    if counts.size == 0:
        return 0
    flat = sums.flatten()
    wp.utils.array_scan(counts.flatten(), flat)
    return int(flat[-1:].numpy()[0])


def _bytes(words: wp.array) -> wp.array:
    """View words as (N, 8) uint8, without a copy; little-endian, as all devices of Warp are."""
    return wp.array(ptr=words.ptr, shape=(len(words), BYTES), dtype=wp.uint8, device=words.device, copy=False)
