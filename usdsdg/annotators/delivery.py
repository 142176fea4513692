"""Where the arrays of an annotator are delivered, and whether they are copies."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from usdsdg.annotators.augmentations.array_transform import ArrayTransform
from usdsdg.session.engines import renderer_device


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
