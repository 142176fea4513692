"""All triangles of all instances in the world, for the CUDA back end."""

import warp as wp

from usdsdg_render.kernels.types import Instance
from usdsdg_render.kernels.visibility import triangle_of


@wp.kernel(enable_backward=False)
def place_triangles(
    instances: wp.array(dtype=Instance),
    face_instance: wp.array(dtype=wp.int32),
    # out
    points: wp.array(dtype=wp.vec3),
):
    face = wp.tid()
    instance = instances[face_instance[face]]
    triangle = triangle_of(instance, face - instance.first_face)
    points[3 * face] = instance.local_to_world * triangle.p0 + instance.world_origin
    points[3 * face + 1] = instance.local_to_world * triangle.p1 + instance.world_origin
    points[3 * face + 2] = instance.local_to_world * triangle.p2 + instance.world_origin
