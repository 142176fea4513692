"""Cache of prototypes: gprims with the same triangles share one, found by specs, array addresses or content."""

import hashlib
from collections.abc import Collection, Iterable, Mapping
from typing import Any

import numpy as np
from pxr import Usd

from usdsdg import errors
from usdsdg.stage.geometry.skinning import Skinning
from usdsdg_render.geometry import shapes
from usdsdg_render.geometry.color_atlas import atlas_uvs
from usdsdg_render.geometry.curves import tubes
from usdsdg_render.geometry.element_values import element_colors, element_uvs
from usdsdg_render.geometry.mesh_source import MeshSource, read_mesh
from usdsdg_render.geometry.meshes import build_prototype, repainted
from usdsdg_render.geometry.nurbs_patch import read_patch
from usdsdg_render.geometry.prim_surface import PrimSurface
from usdsdg_render.geometry.primvar_faults import warn_of_excess
from usdsdg_render.geometry.skinned_mesh import skinned
from usdsdg_render.geometry.slot_uvs import with_uvs_of_slots
from usdsdg_render.scene.scene import Prototype
from usdsdg_render.usd.prim_kinds import CURVES, MESH, PATCH

# Unused prototypes are kept up to this many triangles in all, for scripts that hide and show objects.
MAX_IDLE_TRIANGLES = 1_000_000
IDLE_OVERHEAD = 1_000  # triangles that each unused prototype counts for beside its own

# Sizes that are rendered correctly [units of the prim].
SMALLEST, LARGEST = 1e-8, 5e9


class PrototypeCache:
    """Prototypes by the specs and by the arrays that they were made of.

    Within one pass over the stage, meshes composed of the same specs are the same and are read once. Otherwise arrays
    at the same addresses are the same while they live, which the cache ensures by holding them. Equal arrays at other
    addresses (a crate file unpacks integers at every read) are found by a hash of their bytes.

    Meshes that differ only in what is painted on them (texture coordinates, colors) share points, triangles and
    normals, so that another paint costs no triangulation, and the device no other tree.
    """

    def __init__(self) -> None:
        self.skinning = Skinning()
        self._by_specs: dict[tuple, Prototype | None] = {}
        self._by_address: dict[tuple, tuple[MeshSource, Prototype | None]] = {}
        self._by_content: dict[bytes, Prototype | None] = {}
        self._unpainted_content: dict[tuple, tuple[MeshSource, bytes]] = {}  # by addresses
        self._paintable: dict[bytes, Prototype] = {}  # the last one of each unpainted content
        self._shapes: dict[shapes.ShapeKey, Prototype] = {}
        self._recent: dict[int, Prototype] = {}  # by id, the least recently used first

    def begin_pass(self) -> None:
        """Forget which specs were read: the stage may have changed since the last pass."""
        self._by_specs.clear()

    def points(self, surface: PrimSurface, *, own: bool = False) -> Prototype | None:
        """Return the prototype of a mesh, a patch, curves or points; None (with a warning) when it has no surface.

        own: not to be shared by specs: a skeleton deforms it, or it varies with time, which layer offsets may make
            differ between references to one layer.
        """
        if own:
            return self._read(surface)
        specs = surface.specs()
        if specs not in self._by_specs:
            self._by_specs[specs] = self._read(surface)
        return self._by_specs[specs]

    def _read(self, surface: PrimSurface) -> Prototype | None:
        if surface.kind in (MESH, PATCH):
            return self._read_mesh(surface)
        prim, time, uv_names = surface.prim, surface.time, surface.uv_names
        tessellate = tubes.tessellate_curves if surface.kind == CURVES else tubes.tessellate_points
        tessellation = tessellate(prim, time, self.skinning)
        if tessellation is None:
            return None
        colors = element_colors(prim, time, tessellation) if surface.colored else None
        uvs = element_uvs(prim, time, uv_names[0], tessellation) if uv_names and not surface.colored else None
        if uvs is not None:
            tessellation = tessellation._replace(uvs=uvs)
        return self._share_tessellation(surface.path, tessellation, colors)

    def _share_tessellation(self, path: str, surface: tubes.Tessellation, colors: np.ndarray | None) -> Prototype:
        content = _digest("round", surface if colors is None else (*surface, colors))
        if content not in self._by_content:
            self._by_content[content] = _warn_if_extreme(
                Prototype(
                    name=path,
                    points=surface.points,
                    triangles=surface.triangles,
                    normals=surface.normals,
                    uvs=surface.uvs if colors is None else atlas_uvs(len(surface.triangles)),
                    triangle_slots=np.zeros(len(surface.triangles), np.int32),
                    triangle_faces=surface.owners,
                    colors=colors,
                )
            )
        found = self._by_content[content]
        assert found is not None
        return found

    def _read_mesh(self, surface: PrimSurface) -> Prototype | None:
        prim, time, uv_names = surface.prim, surface.time, surface.uv_names
        uv_name = "".join(uv_names[:1])
        is_patch = surface.kind == PATCH
        if is_patch:
            source = read_patch(prim, time, self.skinning, uv_name=uv_name, colored=surface.colored)
        else:
            source = read_mesh(prim, time, uv_name=uv_name, subsets=surface.subsets, colored=surface.colored)
        if source is None:
            return None
        # No material reads texture coordinates without a name.
        warn_of_excess(surface.path, source if any(uv_names) else source._replace(uvs=None))
        if len(uv_names) > 1:
            source = with_uvs_of_slots(source, prim, time, uv_names)
        if not is_patch:  # of which the control points were skinned
            source = skinned(source, prim, time, self.skinning)
        addresses = _addresses(source)
        entry = self._by_address.get(addresses)
        if entry is None:
            unpainted = source.without_paint()
            places = _addresses(unpainted)
            shape = self._unpainted_content[places][1] if places in self._unpainted_content else _content(unpainted)
            content = _digest(repr((shape, source.painted_settings())), source.painted_arrays())
            if content in self._by_content:
                # One entry by address is enough: a crate file unpacks to another address at every read.
                return self._by_content[content]
            prototype = self._by_content[content] = self._paint(surface.path, source, shape)
            entry = self._by_address[addresses] = (source, prototype)
            if prototype is not None and prototype.corners is not None:
                self._unpainted_content[places] = unpainted, shape
                self._paintable[shape] = prototype
        return entry[1]

    def _paint(self, path: str, source: MeshSource, shape: bytes) -> Prototype | None:
        """Make a prototype: from one with the same unpainted content if there is one."""
        if shape in self._paintable:
            return repainted(path, self._paintable[shape], source)
        prototype = build_prototype(path, source)
        return prototype and _warn_if_extreme(prototype)

    def shape(self, prim: Usd.Prim, time: Usd.TimeCode) -> Prototype | None:
        """Return the prototype of an analytic shape; None (with a warning) when it has no surface."""
        key = shapes.shape_key(prim, time)
        if key is None:
            return None
        if key not in self._shapes:
            surface = shapes.tessellate(key)
            count = len(surface.triangles)
            self._shapes[key] = _warn_if_extreme(
                Prototype(
                    name=str(prim.GetPath()),
                    points=surface.points,
                    triangles=surface.triangles,
                    normals=surface.normals,
                    uvs=surface.uvs,
                    triangle_slots=np.zeros(count, np.int32),
                    triangle_faces=np.arange(count, dtype=np.int32),
                )
            )
        return self._shapes[key]

    def drop_idle(self, used: Mapping[int, Prototype]) -> Collection[int]:
        """Drop the least recently used prototypes beyond MAX_IDLE_TRIANGLES, none in `used`; return ids of the rest."""
        for number, prototype in used.items():
            self._recent.pop(number, None)
            self._recent[number] = prototype
        idle = {number: IDLE_OVERHEAD + len(p.triangles) for number, p in self._recent.items() if number not in used}
        size = sum(idle.values())
        dropped = set()
        for number, triangles in idle.items():
            if size <= MAX_IDLE_TRIANGLES:
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
            self._paintable = {k: prototype for k, prototype in self._paintable.items() if id(prototype) not in dropped}
            unpainted = self._unpainted_content.items()
            self._unpainted_content = {k: entry for k, entry in unpainted if entry[1] in self._paintable}
        return self._recent.keys()


def _warn_if_extreme(prototype: Prototype) -> Prototype:
    """Return the prototype; warn if its size is out of range: shading needs the fourth power of it in float32."""
    size = float((prototype.points.max(axis=0).astype(float) - prototype.points.min(axis=0)).max())
    if not SMALLEST <= size <= LARGEST:
        errors.warn_once(
            f"{prototype.name}: it is {size:.1g} units large before any transform, and 32-bit numbers show "
            f"{SMALLEST:g} to {LARGEST:g}: it may be black or missing. Author its points in "
            f"other units, and scale the prim."
        )
    return prototype


def _addresses(source: MeshSource) -> tuple[Any, ...]:
    return (*(_address(array) for array in source.arrays()), source.settings())


def _address(array: np.ndarray) -> tuple[Any, ...]:
    # USD gives an empty array a place of its own at every read.
    return array.__array_interface__["data"][0] if len(array) else 0, len(array)


def _content(source: MeshSource) -> bytes:
    return _digest(repr(source.settings()), source.arrays())


def _digest(settings: str, arrays: Iterable[np.ndarray]) -> bytes:
    digest = hashlib.blake2b(settings.encode(), digest_size=16)
    for array in arrays:
        digest.update(f"{array.dtype.str}{array.shape}".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.digest()
