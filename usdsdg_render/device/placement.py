"""Where the instances of a scene are: records that kernels read, boxes in the world, and the tree over these.

All of it is written in place and sent to the device in one piece: a frame update is this and little else.
"""

from typing import Any

import numpy as np
import warp as wp

from usdsdg.errors import warn_once
from usdsdg_render.bvh.acceleration_structure import TlasBuilder, tlas_node_dtype
from usdsdg_render.geometry.support_function import SUPPORT_SHAPE
from usdsdg_render.kernels.scene.place import Places, place
from usdsdg_render.memory.staging_buffer import LINE, Mirror, shared
from usdsdg_render.scene import structs

RECORD = np.dtype(structs.Instance.numpy_dtype())


class Placement:
    """Instances keep their row numbers.

    Attributes:
        lower, upper: (N, 3) float32 corners of boxes in the world.
        placed: (N,) bool: whether a ray can meet it.
    """

    def __init__(self, device: str) -> None:
        self.device = device
        self._fit(0, 0)

    def set_instances(self, rows: np.ndarray, prototype: np.ndarray, supports: np.ndarray, filled: np.ndarray) -> None:
        """What the instances are; where they are comes next, from `place`.

        Args:
            rows: (N,) records, of which places are not read.
            prototype: (N,) which of `supports` each has.
            supports: (prototypes, *SUPPORT_SHAPE) how far each reaches.
            filled: (N,) bool: whether it has triangles.
        """
        if (len(rows), len(supports)) != (len(self._rows), len(self._supports)):
            self._fit(len(rows), len(supports))
        self._rows[:], self._prototype[:], self._supports[:], self._filled[:] = rows, prototype, supports, filled

    def place(self, tree: Any, local_to_world: np.ndarray, paths: tuple[str, ...]) -> None:
        """Put them somewhere, (N, 4, 4) as in `scene.Instances`, and make a `structs.Tlas` of them."""
        if len(self._rows):
            self._matrices[:] = local_to_world
            self._placing.launch()
            _warn_of_flat(self._solid, paths)
            np.logical_and(self._solid, self._filled, out=self.placed)
        which = np.flatnonzero(self.placed)
        nodes = self._top.build(which) if len(which) else 0
        self._mirror.send(self._nodes_at + nodes * tlas_node_dtype(self.device).itemsize)
        tree.instance_count = len(which)
        tree.nodes, tree.instances, tree.order = self._on_device

    def _fit(self, count: int, prototypes: int) -> None:
        """Make room for so many."""
        order_at = count * RECORD.itemsize
        self._nodes_at = -(-(order_at + 4 * count) // LINE) * LINE
        # An inner node has at least two children, so there are fewer of them than instances.
        node = tlas_node_dtype(self.device)
        self._mirror = mirror = Mirror(self._nodes_at + max(count, 1) * node.itemsize, self.device)
        self._on_device = (
            mirror.address(self._nodes_at),
            mirror.array(0, count, structs.Instance),
            mirror.array(order_at, count, wp.int32),
        )
        self._rows = mirror.host[:order_at].view(RECORD)
        order = mirror.host[order_at : order_at + 4 * count].view(np.int32)
        nodes = mirror.host[self._nodes_at :].view(node.base).reshape(-1, *node.shape)

        self.lower, self.upper = np.zeros((2, count, 3), np.float32)
        self.placed, self._filled = np.zeros((2, count), bool)
        self._matrices = np.zeros((count, 4, 4))
        self._prototype, self._solid = np.zeros(count, np.int32), np.zeros(count, np.uint8)
        self._supports = np.zeros((prototypes, *SUPPORT_SHAPE))
        self._top = TlasBuilder(self.lower, self.upper, nodes, order, self.device)
        if count:
            self._placing = wp.launch(place, dim=count, inputs=[self._places()], device="cpu", record_cmd=True)

    def _places(self) -> Any:
        places = Places()
        places.matrices = shared(self._matrices, wp.mat44d)
        places.prototype = shared(self._prototype, wp.int32)
        places.supports = shared(self._supports.reshape(len(self._supports), -1), wp.float64)
        places.instances = shared(self._rows, structs.Instance)
        places.lower, places.upper = shared(self.lower, wp.vec3), shared(self.upper, wp.vec3)
        places.solid = shared(self._solid, wp.uint8)
        return places


def _warn_of_flat(solid: np.ndarray, paths: tuple[str, ...]) -> None:
    """Name instances without a volume in the world."""
    for k in np.flatnonzero(solid == 0):
        warn_once(
            f"{paths[k]} is not in the picture: its transform is flat or not finite. Give it a non-zero scale.",
            key=f"flat:{paths[k]}",
        )
