"""Tessellate curves as round tubes with flat ends, and points as spheres."""

from typing import NamedTuple

import numpy as np
from pxr import Usd

from usdsdg import errors
from usdsdg.stage.geometry.skinning import Skinning
from usdsdg_render.geometry.curves.polylines import Polylines, count_segments, read_polylines
from usdsdg_render.geometry.curves.sections import Sections, section_counts, sections_of, unit
from usdsdg_render.geometry.curves.steps import MOST_TRIANGLES, count_triangles, most_doublings, wanted_doublings
from usdsdg_render.geometry.curves.widths import read_widths, width_values
from usdsdg_render.geometry.mesh_source import read_points
from usdsdg_render.geometry.subdivision.rules import INFINITE, ControlMesh, refine

# (most segments, samples of a segment, sides of a tube): the first row that fits counts. `steps` may add samples.
TUBES = ((2_000, 8, 16), (20_000, 6, 8), (100_000, 4, 6), (1_000_000, 2, 4), (10**12, 1, 3))
# (most points, refinement levels of an octahedron): the first row that fits counts.
SPHERES = ((500, 4), (5_000, 3), (50_000, 2), (500_000, 1), (10**12, 0))


class Tessellation(NamedTuple):
    """Triangles with faceVarying normals and UVs, and the curve or point that each belongs to."""

    points: np.ndarray  # (V, 3) float32
    triangles: np.ndarray  # (T, 3) int32
    normals: np.ndarray  # (T, 3, 3) float32
    uvs: np.ndarray  # (T, 3, 2) float32
    owners: np.ndarray  # (T,) int32


def tessellate_curves(prim: Usd.Prim, time: Usd.TimeCode, skinning: Skinning) -> Tessellation | None:
    """Tessellate the curves of a prim as tubes; None (with a warning) when none of them can be drawn."""
    segments = count_segments(prim, time)
    steps, sides = next((steps, sides) for most, steps, sides in TUBES if segments <= most)
    skinned = skinning.skin(prim, time)
    points = None if skinned is None else skinned.points
    groups = read_polylines(prim, time, points, steps)
    # By what does not deform, so that the topology stays the same over time, as motion vectors need.
    deforms = not (time.IsDefault() and points is None) and count_triangles(groups, sides) <= MOST_TRIANGLES
    rest = read_polylines(prim, _first(time), None, steps) if deforms else groups
    if doublings := min(most_doublings(groups, sides), wanted_doublings(rest)):
        groups = read_polylines(prim, time, points, steps << doublings)
        rest = read_polylines(prim, _first(time), None, steps << doublings) if deforms else groups
    counts = section_counts(rest, sides)
    if [len(each) for each in counts] != [each.points.shape[1] for each in groups]:  # there are other curves by now
        counts = section_counts(groups, sides)
    tubes = [tube for tube in (_tube(each, count, sides) for each, count in zip(groups, counts)) if tube is not None]
    surface = _join(tubes)
    if surface is None and groups:
        errors.warn_once(
            f"{prim.GetPath()}: its curves are too thin or too short for 32-bit numbers, so nothing is drawn. Make "
            f"them wider or remove the prim."
        )
    return surface


def _first(time: Usd.TimeCode) -> Usd.TimeCode:
    return time if time.IsDefault() else Usd.TimeCode.EarliestTime()


def tessellate_points(prim: Usd.Prim, time: Usd.TimeCode, skinning: Skinning) -> Tessellation | None:
    """Tessellate the points of a prim as spheres; None (with a warning) when there are none."""
    skinned = skinning.skin(prim, time)
    centers = read_points(prim, time) if skinned is None else skinned.points
    if centers is None or not len(centers):
        errors.warn_once(f"{prim.GetPath()}: there are no points, so nothing is drawn. Author them or remove the prim.")
        return None
    widths = read_widths(prim, time)
    values = width_values(prim, widths)
    if widths.interpolation == "constant" or len(values) < len(centers):
        if widths.interpolation != "constant":
            errors.warn_once(
                f"{prim.GetPath()}: {errors.counted(len(values), 'width is', 'widths are')} too few for {len(centers)} "
                f"points; the first one is used. Author one for each, or the interpolation constant."
            )
        values = np.full(len(centers), values[0])
    radii = values[: len(centers)] / 2.0
    good = np.isfinite(centers).all(axis=1) & np.isfinite(radii) & (radii > 0.0)
    if bad := int((~good).sum()):
        errors.warn_once(
            f"{prim.GetPath()}: {errors.counted(bad, 'point is', 'points are')} NaN or infinite or of no width > 0; "
            f"nothing is drawn there. Correct points and widths."
        )
    return _spheres(np.asarray(centers, np.float64)[good], radii[good], np.flatnonzero(good)) if good.any() else None


def _spheres(centers: np.ndarray, radii: np.ndarray, owners: np.ndarray) -> Tessellation:
    levels = next(levels for most, levels in SPHERES if len(centers) <= most)
    ball, faces = _unit_sphere(levels)
    vertices = centers[:, None] + ball * radii[:, None, None]
    triangles = faces + len(ball) * np.arange(len(centers))[:, None, None]
    count = len(centers)
    longitude = np.arctan2(ball[:, 1], ball[:, 0]) / (2 * np.pi) % 1.0
    uv = np.stack([longitude, np.arccos(np.clip(-ball[:, 2], -1, 1)) / np.pi], axis=-1)[faces]
    return Tessellation(
        vertices.reshape(-1, 3).astype(np.float32),
        triangles.reshape(-1, 3).astype(np.int32),
        np.tile(ball[faces].astype(np.float32), (count, 1, 1)),
        np.tile(uv.astype(np.float32), (count, 1, 1)),
        np.repeat(owners, len(faces)).astype(np.int32),
    )


def _unit_sphere(levels: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (V, 3) and triangles (T, 3) of a unit sphere: a refined octahedron."""
    vertices = np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
    faces = np.array([k for j in range(4) for k in (j, (j + 1) % 4, 4, (j + 1) % 4, j, 5)])
    sphere = ControlMesh(vertices, np.full(6, INFINITE), np.full(8, 3), faces, np.full(24, INFINITE))
    for _ in range(levels):
        sphere = refine(sphere, 1, loop=True)
        sphere = sphere._replace(values=sphere.values / np.linalg.norm(sphere.values, axis=1, keepdims=True))
    return sphere.values, sphere.indices.reshape(-1, 3)


def _tube(polylines: Polylines, counts: np.ndarray, sides: int) -> Tessellation | None:
    """Tessellate curves with `counts` (K,) circles at each sample."""
    sections = sections_of(polylines, counts)
    across = _frames(sections, polylines.closed)
    aside = np.cross(sections.tangents, across)
    angle = np.arange(sides) * (2 * np.pi / sides)
    # (C, S, sides, 3) directions from the curve to the tube
    outward = across[:, :, None] * np.cos(angle)[:, None] + aside[:, :, None] * np.sin(angle)[:, None]
    rings = sections.points[:, :, None] + outward * np.maximum(sections.radii, 0.0)[:, :, None, None]
    count, samples = sections.points.shape[:2]
    here = np.arange(samples if polylines.closed else samples - 1)[:, None]
    next_ring, side = (here + 1) % samples, np.arange(sides)
    next_side = (side + 1) % sides
    quads = np.stack(
        [here * sides + side, here * sides + next_side, next_ring * sides + next_side, next_ring * sides + side],
        axis=-1,
    ).reshape(-1, 4)
    triangles = quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    column = np.broadcast_to(np.stack([side, side + 1, side + 1, side], -1) / sides, (len(here), sides, 4))
    chords = len(counts) if polylines.closed else len(counts) - 1
    along = np.append(sections.along, chords)
    row = np.stack([along[here], along[here], along[here + 1], along[here + 1]], -1) / max(chords, 1)
    uv = np.stack([column, np.broadcast_to(row, column.shape)], -1).reshape(-1, 4, 2)[:, [[0, 1, 2], [0, 2, 3]]]
    offset = samples * sides * np.arange(count)[:, None, None]
    tube = Tessellation(
        rings.reshape(-1, 3).astype(np.float32),
        (triangles + offset).reshape(-1, 3).astype(np.int32),
        outward.reshape(count, -1, 3)[:, triangles].reshape(-1, 3, 3).astype(np.float32),
        np.tile(uv.reshape(-1, 3, 2), (count, 1, 1)).astype(np.float32),
        np.repeat(polylines.curves, len(triangles)).astype(np.int32),
    )
    return tube if polylines.closed else _join([tube, *_caps(polylines, sections.tangents, rings)])


def _caps(polylines: Polylines, tangent: np.ndarray, rings: np.ndarray) -> list[Tessellation]:
    """Flat disks over both ends."""
    caps = []
    count, sides = len(rings), rings.shape[2]
    fan = np.stack([np.zeros(sides, int), 1 + np.arange(sides), 1 + (np.arange(sides) + 1) % sides], axis=-1)
    for end, sign, v in ((0, -1.0, 0.0), (-1, 1.0, 1.0)):
        vertices = np.concatenate([polylines.points[:, end, None], rings[:, end]], axis=1)
        faces = fan if sign > 0 else fan[:, ::-1]
        triangles = faces + (sides + 1) * np.arange(count)[:, None, None]
        normal = np.broadcast_to(sign * tangent[:, end, None, None], (count, sides, 3, 3))
        caps.append(
            Tessellation(
                vertices.reshape(-1, 3).astype(np.float32),
                triangles.reshape(-1, 3).astype(np.int32),
                normal.reshape(-1, 3, 3).astype(np.float32),
                np.broadcast_to(np.array([0.5, v], np.float32), (count * sides, 3, 2)),
                np.repeat(polylines.curves, sides).astype(np.int32),
            )
        )
    return caps


def _frames(sections: Sections, closed: bool) -> np.ndarray:
    """(C, S, 3) unit vectors in the planes of circles, with minimal rotation along the curve."""
    tangent, count = sections.tangents, sections.points.shape[1]
    start = tangent[:, 0]
    least = np.eye(3)[np.argmin(np.abs(start), axis=1)]
    across = np.empty_like(tangent)
    across[:, 0] = unit(np.cross(start, least), np.array([1.0, 0.0, 0.0]))
    for k in range(1, count):
        across[:, k] = _transport(across[:, k - 1], tangent[:, k - 1], tangent[:, k])
    if closed:  # the rotation left after one round is undone evenly, so that the ends meet
        back = _transport(across[:, -1], tangent[:, -1], start)
        turned = np.arctan2(
            np.einsum("ci,ci->c", np.cross(back, across[:, 0]), start), np.einsum("ci,ci->c", back, across[:, 0])
        )
        angle = turned[:, None] * np.arange(count) / count
        across = across * np.cos(angle)[..., None] + np.cross(tangent, across) * np.sin(angle)[..., None]
    return across


def _transport(vector: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Parallel transport: (C, 3) `vector`, orthogonal to `before`, rotated by the least rotation to `after`."""
    axis = np.cross(before, after)
    cosine = np.einsum("ci,ci->c", before, after)[:, None]
    along = np.einsum("ci,ci->c", axis, vector)[:, None]
    turned = vector * cosine + np.cross(axis, vector) + axis * along / np.maximum(1.0 + cosine, 1e-9)
    turned = np.where(cosine > -0.9999, turned, vector)
    flat = turned - after * np.einsum("ci,ci->c", turned, after)[:, None]
    return unit(flat, np.array([1.0, 0.0, 0.0]))


def _join(parts: list[Tessellation]) -> Tessellation | None:
    """Concatenate tessellations without degenerate triangles; None if no triangle is left."""
    if not parts:
        return None
    first = np.cumsum([0, *(len(part.points) for part in parts[:-1])])
    triangles = np.concatenate([part.triangles + start for part, start in zip(parts, first)])
    vertices = np.concatenate([part.points for part in parts])
    a, b, c = (vertices[triangles[:, k]].astype(np.float64) for k in range(3))
    solid = np.linalg.norm(np.cross(b - a, c - a), axis=1) > 0.0
    if not solid.any():
        return None
    return Tessellation(
        vertices,
        triangles[solid].astype(np.int32),
        *(np.concatenate([part[k] for part in parts])[solid] for k in (2, 3, 4)),
    )
