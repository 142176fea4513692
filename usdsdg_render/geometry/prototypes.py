"""One `Prototype` for all gprims with the same triangles: recognized by shared memory, else by content."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterable, Mapping
from typing import Any

import numpy as np
from pxr import Sdf, Usd

from usdsdg import errors
from usdsdg.stage.geometry.skinning import Skinning
from usdsdg_render.geometry import shapes, tubes
from usdsdg_render.geometry.color_atlas import atlas_uvs, element_colors
from usdsdg_render.geometry.mesh_source import MeshSource, read_mesh
from usdsdg_render.geometry.meshes import build_prototype
from usdsdg_render.geometry.skinned_mesh import posed
from usdsdg_render.scene.scene import Prototype
from usdsdg_render.usd.prim_kinds import CURVES, IGNORED_PREFIXES, MESH, kind_of

# Prototypes that nothing uses any more are kept while they are few, for scripts that hide and show objects.
IDLE_TRIANGLES = 1_000_000
IDLE_LEAST = 1_000  # that each counts for besides its own

# Sizes that pictures show without fault [units of the prim].
SMALLEST, LARGEST = 1e-8, 5e9


class PrototypeCache:
    """Prototypes by the arrays they were made of.

    Within one pass over the stage, meshes composed of the same specs are the same and are read once. Else arrays of the
    same memory are the same as long as they live, which the entries see to, and equal arrays at different addresses
    (a crate file unpacks its integers at every read) meet through a hash of their bytes.
    """

    def __init__(self) -> None:
        self.skinning = Skinning()
        self._by_specs: dict[tuple, Prototype | None] = {}
        self._by_address: dict[tuple, tuple[MeshSource, Prototype | None]] = {}
        self._by_content: dict[bytes, Prototype | None] = {}
        self._shapes: dict[shapes.ShapeKey, Prototype] = {}
        self._recent: dict[int, Prototype] = {}  # by id, the longest idle first

    def begin_pass(self) -> None:
        """The stage may have changed since the last pass, so where a value comes from no longer tells which it is."""
        self._by_specs.clear()

    def points(
        self,
        prim: Usd.Prim,
        time: Usd.TimeCode,
        uv_name: str,
        subsets: list[Usd.Prim],
        *,
        own: bool = False,
        colored: bool = False,
    ) -> Prototype | None:
        """The prototype of a mesh, of curves or of points; None (with a warning) when it has no surface.

        own: it is not what its specs say alone: it varies with time, and layer offsets may give references of one layer
            different times, or a skeleton shapes it.
        colored: with its displayColor and displayOpacity, which vary.
        """
        if own:
            return self._read(prim, time, uv_name, subsets, colored)
        specs = (kind_of(prim), uv_name, colored, _specs(prim), *(_specs(subset) for subset in subsets))
        if specs not in self._by_specs:
            self._by_specs[specs] = self._read(prim, time, uv_name, subsets, colored)
        return self._by_specs[specs]

    def _read(
        self, prim: Usd.Prim, time: Usd.TimeCode, uv_name: str, subsets: list[Usd.Prim], colored: bool
    ) -> Prototype | None:
        kind = kind_of(prim)
        if kind == MESH:
            return self._read_mesh(prim, time, uv_name, subsets, colored)
        draw = tubes.curves if kind == CURVES else tubes.points
        surface = draw(prim, time, self.skinning)
        if surface is None:
            return None
        colors = None
        if colored:
            # Points have a color each; curves that change their color on the way are drawn with the mean.
            elements = ("uniform",) if kind == CURVES else ("vertex", "varying")
            colors = element_colors(prim, time, surface.owners, elements)
        return self._share_round(str(prim.GetPath()), surface, colors)

    def _share_round(self, path: str, surface: tubes.Round, colors: np.ndarray | None) -> Prototype:
        content = _digest("round", surface if colors is None else (*surface, colors))
        if content not in self._by_content:
            self._by_content[content] = _named_if_extreme(
                Prototype(
                    name=path,
                    points=surface.points,
                    triangles=surface.triangles,
                    corner_normals=surface.corner_normals,
                    corner_uvs=surface.corner_uvs if colors is None else atlas_uvs(len(surface.triangles)),
                    triangle_slots=np.zeros(len(surface.triangles), np.int32),
                    triangle_faces=surface.owners,
                    corner_colors=None if colors is None else np.repeat(colors[:, None], 3, axis=1),
                )
            )
        found = self._by_content[content]
        assert found is not None
        return found

    def _read_mesh(
        self, prim: Usd.Prim, time: Usd.TimeCode, uv_name: str, subsets: list[Usd.Prim], colored: bool
    ) -> Prototype | None:
        source = read_mesh(prim, time, uv_name=uv_name, subsets=subsets, colored=colored)
        if source is None:
            return None
        source = posed(source, prim, time, self.skinning)
        addresses = (*(_address(array) for array in source.arrays()), source.form())
        entry = self._by_address.get(addresses)
        if entry is None:
            content = _content(source)
            if content in self._by_content:
                # One address for each is enough: a crate file unpacks to another one at every read.
                return self._by_content[content]
            prototype = build_prototype(str(prim.GetPath()), source)
            prototype = self._by_content[content] = prototype and _named_if_extreme(prototype)
            entry = self._by_address[addresses] = (source, prototype)
        return entry[1]

    def shape(self, prim: Usd.Prim, time: Usd.TimeCode) -> Prototype | None:
        """The prototype of an analytic shape; None (with a warning) when it has no surface."""
        key = shapes.shape_key(prim, time)
        if key is None:
            return None
        if key not in self._shapes:
            surface = shapes.tessellate(key)
            count = len(surface.triangles)
            self._shapes[key] = _named_if_extreme(
                Prototype(
                    name=str(prim.GetPath()),
                    points=surface.points,
                    triangles=surface.triangles,
                    corner_normals=surface.corner_normals,
                    corner_uvs=surface.corner_uvs,
                    triangle_slots=np.zeros(count, np.int32),
                    triangle_faces=np.arange(count, dtype=np.int32),
                )
            )
        return self._shapes[key]

    def drop_idle(self, used: Mapping[int, Prototype]) -> Collection[int]:
        """Drop the longest idle prototypes, not in `used`, while idle ones are many; ids of those that are kept."""
        for number, prototype in used.items():
            self._recent.pop(number, None)
            self._recent[number] = prototype
        idle = {number: IDLE_LEAST + len(p.triangles) for number, p in self._recent.items() if number not in used}
        size = sum(idle.values())
        dropped = set()
        for number, triangles in idle.items():
            if size <= IDLE_TRIANGLES:
                break
            size -= triangles
            dropped.add(number)
            del self._recent[number]
        if dropped:
            self._by_address = {k: entry for k, entry in self._by_address.items() if id(entry[1]) not in dropped}
            self._by_content = {
                k: prototype for k, prototype in self._by_content.items() if id(prototype) not in dropped
            }
            self._shapes = {k: prototype for k, prototype in self._shapes.items() if id(prototype) not in dropped}
        return self._recent.keys()


def _named_if_extreme(prototype: Prototype) -> Prototype:
    """The prototype; 32-bit numbers cannot shade triangles whose sides to the fourth power are none."""
    size = float((prototype.points.max(axis=0).astype(float) - prototype.points.min(axis=0)).max())
    if not SMALLEST <= size <= LARGEST:
        errors.warn_once(
            f"{prototype.name}: it is {size:.1g} units large before any transform, and 32-bit numbers show "
            f"{SMALLEST:g} to {LARGEST:g}: it may be black or missing. Author its points in "
            f"other units, and scale the prim."
        )
    return prototype


def _specs(prim: Usd.Prim) -> tuple:
    """Which specs give a prim its shape. Those that only say something of physics or labels make no difference."""
    return tuple((spec.layer.identifier, spec.path) for spec in prim.GetPrimStack() if _shapes_something(spec))


def _shapes_something(spec: Sdf.PrimSpec) -> bool:
    return any(not name.startswith(IGNORED_PREFIXES) for name in spec.properties.keys())  # noqa: SIM118


def _address(array: np.ndarray) -> tuple[Any, ...]:
    return array.__array_interface__["data"][0], len(array)


def _content(source: MeshSource) -> bytes:
    return _digest(repr(source.form()), source.arrays())


def _digest(form: str, arrays: Iterable[np.ndarray]) -> bytes:
    digest = hashlib.blake2b(form.encode(), digest_size=16)
    for array in arrays:
        digest.update(f"{array.dtype.str}{array.shape}".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.digest()
