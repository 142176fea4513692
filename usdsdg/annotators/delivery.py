"""Delivery of annotations: NumPy arrays on the host, or Warp arrays on a device, and whether they are copies."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from usdsdg.annotators.augmentations.array_transform import ArrayTransform
from usdsdg.annotators.augmentations.warp_kernel import device_or_cpu
from usdsdg.annotators.base import Annotation
from usdsdg.annotators.pixels.launch import Pixels, is_image, on_host, viewed
from usdsdg.errors import ArgumentError
from usdsdg.session.devices.choice import renderer_device
from usdsdg.snapshots import snapshot

_DEVICE = re.compile(r"cpu|cuda(:\d+)?")


@dataclass(frozen=True)
class Delivery:
    """How an annotator delivers its arrays.

    device: what it was created with: None or "cpu" for NumPy arrays, else that of Warp arrays.
    is_moved: whether a Warp kernel has augmented them, which moves an annotator without a device to the renderer's, as
        in Replicator.
    copies: whether arrays are copies, which may be written into.
    """

    device: str | None = None
    is_moved: bool = False
    copies: bool = True

    def warp_device(self, *, kernels: bool = True) -> str | None:
        """Return the device of Warp arrays; None for NumPy arrays. kernels: whether moves by Warp kernels count."""
        if self.device not in (None, "cpu"):
            return self.device
        return renderer_device() if kernels and self.is_moved else None

    def augmented(self, transforms: Iterable[ArrayTransform], device: str | None = None) -> Delivery:
        """Return the delivery of what these have augmented, on a device that is given, or where it was."""
        is_moved = device is None and (self.is_moved or any(each.gives_warp_array for each in transforms))
        return replace(self, device=device or self.device, is_moved=is_moved)

    def of_copy(self, device: str | None, copies: bool) -> Delivery:
        """Return the delivery of a copy of the annotator, which copies arrays only where both want it."""
        return Delivery(device or self.device, self.is_moved and device is None, self.copies and copies)


def checked_device(device: str | None) -> str | None:
    """Return the name of a device in lower case, or None as it is.

    Raises:
        ArgumentError: it is neither None, "cpu", "cuda" nor "cuda:<number>".
    """
    if device is not None and (not isinstance(device, str) or not _DEVICE.fullmatch(device.lower())):
        raise ArgumentError(f"device is {device!r}; expected 'cpu', 'cuda' or 'cuda:0'")
    return device.lower() if device else None


def delivered(
    annotation: Annotation,
    warp_device: str | None,
    *,
    copy: bool,
    copy_tables: bool = True,
    fetch: Callable[[Pixels], np.ndarray] = on_host,
) -> Annotation:
    """Return an annotation as its reader gets it.

    warp_device: None for NumPy arrays, else that of Warp arrays; info is NumPy in any case. copy: whether arrays are
        copies, which the reader may write into. copy_tables: the same of the dictionaries and lists in info. fetch: how
        images of a GPU come to the host.
    """

    def hosted(value: Any) -> Any:
        if not is_image(value):
            # Tables of labels are kept from frame to frame and shared by annotators.
            return snapshot(value) if copy_tables else value
        return fetch(value).copy() if copy else fetch(value)

    data, info = annotation.data, {key: hosted(value) for key, value in annotation.info.items()}
    if data is None or warp_device is None:
        return Annotation(hosted(data), info)
    return Annotation(on_device(data, warp_device, copy=copy), info)


def on_device(data: Pixels, device: str, *, copy: bool) -> Pixels:
    """Return an array as a Warp array of numbers on `device`, on the CPU if there is no such device.

    As in Replicator, ids are int32 in Warp arrays; they stay below 2³¹. Structured arrays and texts stay NumPy arrays,
    since Warp has none. copy: if False, an array that is there already shares its memory.
    """
    import warp as wp

    if isinstance(data, np.ndarray):
        if data.dtype.kind not in "biuf":
            return data.copy() if copy else data
        return wp.array(
            data.view(np.int32) if data.dtype == np.uint32 else data, device=device_or_cpu(device), copy=copy
        )
    scalar = getattr(data.dtype, "_wp_scalar_type_", data.dtype)
    channels = getattr(data.dtype, "_shape_", ())
    found = viewed(data, wp.int32 if scalar == wp.uint32 else scalar, (*data.shape, *channels))
    where = wp.get_device(device_or_cpu(device))
    return found.to(where) if found.device != where else wp.clone(found) if copy else found
