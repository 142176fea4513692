"""Gprims that are divided into parts, such as the GeomSubsets of a mesh, on the device."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import warp as wp

from usdsdg.parallel import CUDA_BLOCK
from usdsdg_render.kernels.labels.coverage import Parts, fill_mask_words
from usdsdg_render.kernels.labels.parts import fill_words_of_parts, tell_parts_apart
from usdsdg_render.scene.scene import Scene

# By the index of a gprim: the entry of each of its faces, (F,). Entries are all gprims, then all parts.
FaceEntries = Mapping[int, np.ndarray]


class DividedGprims:
    """The entries of a scene; where no gprim is divided, they are its gprims."""

    def __init__(self, scene: Scene, faces: FaceEntries, device: str) -> None:
        instances, self._device = scene.instances, device
        count = max([len(instances), *(int(of_face.max()) + 1 for of_face in faces.values())])
        self.instances = np.arange(count)  # of each entry
        first, entries, total = np.full(len(instances), -1, np.int32), [np.zeros(0, np.int32)], 0
        for gprim, of_face in faces.items():
            self.instances[of_face] = gprim
            shape = scene.prototypes[int(instances.prototype[gprim])]
            # A face is out of range only where the mesh itself is broken.
            entries.append(of_face[np.minimum(shape.triangle_faces, len(of_face) - 1)])
            first[gprim], total = total, total + len(entries[-1])
        self.are_there, self.record = bool(faces), Parts()
        if not self.are_there:
            return
        for name, values in (("instance", self.instances), ("first", first), ("entry", np.concatenate(entries))):
            setattr(self.record, name, wp.array(values, dtype=wp.int32, device=device))

    @property
    def fill_kernel(self) -> wp.Kernel:
        """The kernel that fills the words of masks of entries."""
        return fill_words_of_parts if self.are_there else fill_mask_words

    def tell_apart(self, instance: wp.array, triangle: wp.array) -> None:
        """Replace the instances of pixels or hits by their entries."""
        if self.are_there:
            given = [self.record, triangle.flatten()]
            wp.launch(
                tell_parts_apart, instance.size, given, [instance.flatten()], device=self._device, block_dim=CUDA_BLOCK
            )
