"""Warp functions that find the corner of a hull that is farthest along a direction, for the narrow phase on the CPU."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

from pathlib import Path
from typing import Any

import newton
import warp as wp
from newton._src.geometry.support_function import support_map, unpack_mesh_ptr

HULL = wp.constant(int(newton.GeoType.CONVEX_MESH))


@wp.func_native(f"{{\n{(Path(__file__).parent / 'farthest_corner.cpp').read_text()}\n}}")
def farthest_corner(id: wp.uint64, direction: wp.vec3) -> int: ...


# Newton calls it in a hundred places, so that a copy in each would take long to compile.
@wp.func(inline=False)
def support_with_fast_hulls(geom: Any, direction: wp.vec3, data_provider: Any) -> wp.vec3:
    """Return the point of a shape that is farthest along a direction, as Newton's `support_map` to the bit."""
    if geom.shape_type == HULL:
        id = unpack_mesh_ptr(geom.auxiliary)
        mesh = wp.mesh_get(id)
        corner = farthest_corner(id, wp.cw_mul(direction, geom.scale))
        return wp.cw_mul(mesh.points[corner], geom.scale)
    return support_map(geom, direction, data_provider)
