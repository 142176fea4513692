"""Transforms of all instances on the device: their records, world bounding boxes, and the TLAS over these.

They are updated in place in one staging buffer and uploaded in one copy, which is most of the work of a frame update.
"""

from typing import Any

import numpy as np
import warp as wp

from usdsdg.errors import warn_once
from usdsdg_render.bvh.acceleration_structure import TlasBuilder, tlas_node_dtype
from usdsdg_render.geometry.support_function import SUPPORT_SHAPE
from usdsdg_render.kernels.scene.instance_transforms import InstanceTransforms, set_instance_transforms
from usdsdg_render.memory.staging_buffer import CACHE_LINE, StagingBuffer, shared
from usdsdg_render.scene import structs

RECORD = np.dtype(structs.Instance.numpy_dtype())  # pyright: ignore[reportCallIssue]


class Placement:
    """Records, world boxes and TLAS of the instances of a scene, which keep their row numbers.

    Attributes:
        rows: (N,) records.
        prototype: (N,) row of `supports` of each.
        supports: (prototypes, *SUPPORT_SHAPE) tables of support functions.
        filled: (N,) bool: whether it has triangles.
        version: how often these were set.
        lower, upper: (N, 3) float32 corners of boxes in the world.
        placed: (N,) bool: whether rays can hit it.
    """

    def __init__(self, device: str) -> None:
        self.device, self.version = device, 0
        self._fit(0, 0)

    def set_instances(self, rows: np.ndarray, prototype: np.ndarray, supports: np.ndarray, filled: np.ndarray) -> None:
        """Set what the instances are, as in the attributes; `set_transforms` must follow.

        rows: of which the transforms are not read.
        """
        if (len(rows), len(supports)) != (len(self.rows), len(self.supports)):
            self._fit(len(rows), len(supports))
        self.version += 1
        self.rows[:], self.prototype[:], self.supports[:], self.filled[:] = rows, prototype, supports, filled

    def set_transforms(self, tlas: Any, local_to_world: np.ndarray, paths: tuple[str, ...]) -> None:
        """Set the transforms, (N, 4, 4) as in `scene.Instances`, and fill a `structs.Tlas`. Warnings name `paths`."""
        if len(self.rows):
            assert self._launch is not None
            self._matrices[:] = local_to_world
            self._launch.launch()
            warn_of_singular(self._invertible, paths)
            np.logical_and(self._invertible, self.filled, out=self.placed)
        placed = np.flatnonzero(self.placed)
        nodes = self._tlas_builder.build(placed) if len(placed) else 0
        self._staging.upload(self._nodes_at + nodes * tlas_node_dtype(self.device).itemsize)
        tlas.instance_count = len(placed)
        tlas.nodes, tlas.instances, tlas.order = self._on_device

    def _fit(self, count: int, prototypes: int) -> None:
        """Allocate memory for `count` instances of `prototypes`."""
        order_at = count * RECORD.itemsize
        self._nodes_at = -(-(order_at + 4 * count) // CACHE_LINE) * CACHE_LINE
        # Inner nodes have at least two children, so there are fewer of them than instances.
        node = tlas_node_dtype(self.device)
        self._staging = staging = StagingBuffer(self._nodes_at + max(count, 1) * node.itemsize, self.device)
        self._on_device = (
            staging.address(self._nodes_at),
            staging.array(0, count, structs.Instance),
            staging.array(order_at, count, wp.int32),
        )
        self.rows = staging.host[:order_at].view(RECORD)
        order = staging.host[order_at : order_at + 4 * count].view(np.int32)
        nodes = staging.host[self._nodes_at :].view(node.base).reshape(-1, *node.shape)

        self.lower, self.upper = np.zeros((2, count, 3), np.float32)
        self.placed, self.filled = np.zeros((2, count), bool)
        self._matrices = np.zeros((count, 4, 4))
        self.prototype, self._invertible = np.zeros(count, np.int32), np.zeros(count, np.uint8)
        self.supports = np.zeros((prototypes, *SUPPORT_SHAPE))
        self._tlas_builder = TlasBuilder(self.lower, self.upper, nodes, order, self.device)
        if count:
            inputs = [self._kernel_arrays(), 0]
            self._launch = wp.launch(set_instance_transforms, dim=count, inputs=inputs, device="cpu", record_cmd=True)

    def _kernel_arrays(self) -> Any:
        transforms = InstanceTransforms()
        transforms.matrices = shared(self._matrices, wp.mat44d)
        transforms.prototype = shared(self.prototype, wp.int32)
        transforms.supports = shared(self.supports.reshape(len(self.supports), -1), wp.float64)
        transforms.instances = shared(self.rows, structs.Instance)
        transforms.lower, transforms.upper = shared(self.lower, wp.vec3), shared(self.upper, wp.vec3)
        transforms.invertible = shared(self._invertible, wp.uint8)
        return transforms


def warn_of_singular(invertible: np.ndarray, paths: tuple[str, ...]) -> None:
    """Warn of instances whose transforms are not invertible."""
    for k in np.flatnonzero(invertible == 0):
        warn_once(
            f"{paths[k]} is not rendered: its transform is singular or not finite. Give it a non-zero scale.",
            key=f"flat:{paths[k]}",
        )
