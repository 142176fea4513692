"""The distance of a hit along its ray, in double precision where single precision is not enough."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportCallIssue=false

import warp as wp

from usdsdg_render.kernels.cameras.camera import Ray
from usdsdg_render.kernels.scene.surface import max_abs
from usdsdg_render.kernels.scene.visibility import triangle_of
from usdsdg_render.scene.structs import Hit, SceneTables

# Queries have an error of some roundings of the size of the triangle. Where that is as many times the distance, such
# as of a floor of kilometers under a camera, it may be more than 1e-5 of the distance.
LARGE = wp.constant(64.0)


@wp.func
def double(v: wp.vec3):
    return wp.vec3d(wp.float64(v[0]), wp.float64(v[1]), wp.float64(v[2]))


@wp.func
def is_large(tables: SceneTables, ray: Ray, hit: Hit):
    """Return whether the triangle of a hit is large beside the distance."""
    instance = tables.tlas.instances[hit.instance]
    triangle = triangle_of(instance, hit.triangle)
    size = max_abs(triangle.p1 - triangle.p0) + max_abs(triangle.p2 - triangle.p0)
    return size > LARGE * hit.t * max_abs(instance.world_to_local * ray.direction)


@wp.func
def distance_of(tables: SceneTables, ray: Ray, hit: Hit):
    """Return the distance [stage units] from the origin of a ray to its hit."""
    if not is_large(tables, ray, hit):
        return hit.t
    instance = tables.tlas.instances[hit.instance]
    triangle = triangle_of(instance, hit.triangle)
    origin = instance.world_to_local * (ray.origin - instance.world_origin)
    corner = double(triangle.p0)
    normal = wp.cross(double(triangle.p1) - corner, double(triangle.p2) - corner)
    along = wp.dot(normal, double(instance.world_to_local * ray.direction))
    if along == wp.float64(0.0):
        return hit.t
    return wp.float32(wp.dot(normal, corner - double(origin)) / along)
