"""Read UsdShade materials and make rows of `scene.MATERIAL` from them."""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, fields

import numpy as np
from pxr import Sdf, Usd, UsdShade

from usdsdg import errors
from usdsdg_render.images.textures import Progress, TexturePool, TextureUse
from usdsdg_render.materials.material_x import SURFACES, read_material_x
from usdsdg_render.materials.mdl import mdl_file, mdl_name, read_mdl
from usdsdg_render.materials.preview_surface import read_preview_surface
from usdsdg_render.materials.shading import MAX_COLOR, MAX_EMISSION, Input, Material, Network, shader_id
from usdsdg_render.scene.scene import MATERIAL, NO_TEXTURE, Texture
from usdsdg_render.usd.prim_kinds import is_below

_COLUMNS = {name: MATERIAL[name] for name in MATERIAL.names or ()}
# Fields of `Material` with the columns that they fill: `normal` and `detail` a texture alone.
_FIELDS = [
    (each.name, f"{each.name}_texture", f"{each.name}_channel")
    for each in fields(Material)
    if {each.name, f"{each.name}_texture"} & _COLUMNS.keys()
]


@dataclass(frozen=True)
class _Entry:
    material: Material | None  # None: its surface shader is missing or unknown
    visited: frozenset[Sdf.Path]
    shared_as: tuple | None


class MaterialLibrary:
    """Cache of materials by prim path, and by the specs that define them where these determine everything.

    Each reference to an asset has its own material prims, but most are composed of the same specs and share an entry.
    An edit of one of them adds a spec, so that it no longer shares.
    """

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        self._by_path: dict[Sdf.Path, _Entry] = {}
        self._by_specs: dict[tuple, _Entry] = {}

    def read(self, prim: Usd.Prim) -> Material | None:
        """Read the material at `prim`; None (with a warning) when its surface shader is missing or unknown."""
        path = prim.GetPath()
        entry = self._by_path.get(path)
        if entry is None:
            specs = _specs(prim)
            entry = self._by_specs.get(specs)
            if entry is None:
                entry = _read(prim, specs)
                if entry.shared_as is not None:
                    self._by_specs[specs] = entry
            self._by_path[path] = entry
        return entry.material

    def invalidate(self, changed: Collection[Sdf.Path], roots: Collection[Sdf.Path]) -> set[Sdf.Path]:
        """Drop and return the materials that depend on a prim of `changed`, or on one at or below `roots`.

        A shading prim that no material is known to depend on may be part of any network, so then all are dropped.
        """
        known, readers = self._by_path, self._readers()
        stale = {path for path in known if is_below(path, roots)}
        stale.update(*(found for visited, found in readers.items() if is_below(visited, roots)))
        for path in [*changed, *roots]:
            found = readers.get(path, set()) | {prefix for prefix in path.GetPrefixes() if prefix in known}
            if not found and path not in stale and self._is_shading(path):
                stale = set(known)
                break
            stale |= found
        self._drop(stale)
        return stale

    def _readers(self) -> dict[Sdf.Path, set[Sdf.Path]]:
        """The materials that depend on each prim."""
        readers: dict[Sdf.Path, set[Sdf.Path]] = {}
        for material, entry in self._by_path.items():
            for visited in entry.visited:
                readers.setdefault(visited, set()).add(material)
        return readers

    def _drop(self, paths: Iterable[Sdf.Path]) -> None:
        """Drop entries, shared ones too: edits of the prims that share them are not tracked."""
        for path in paths:
            entry = self._by_path.pop(path)
            if entry.shared_as is not None:
                self._by_specs.pop(entry.shared_as, None)

    def _is_shading(self, path: Sdf.Path) -> bool:
        prim = self._stage.GetPrimAtPath(path)
        return bool(prim) and not prim.IsA(UsdShade.Material) and UsdShade.ConnectableAPI(prim).IsContainer()

    def keep_only(self, paths: set[Sdf.Path]) -> None:
        """Drop all materials but these, which are still bound."""
        self._drop(path for path in list(self._by_path) if path not in paths)


def _specs(prim: Usd.Prim) -> tuple:
    return tuple((spec.layer.identifier, spec.path) for spec in prim.GetPrimStack())


def _read(prim: Usd.Prim, specs: tuple) -> _Entry:
    network = Network(prim)
    material = _read_surface(network)
    own = prim.GetPath()
    closed = all(path.HasPrefix(own) for path in network.visited) and not any(map(_has_arcs, Usd.PrimRange(prim)))
    return _Entry(material, frozenset(network.visited), specs if closed else None)


def _has_arcs(prim: Usd.Prim) -> bool:
    """Whether the prim has composition arcs of its own, through which edits would not show in the material's specs."""
    return prim.HasAuthoredInherits() or prim.HasAuthoredSpecializes() or prim.HasAuthoredReferences()


def _read_surface(network: Network) -> Material | None:
    material = UsdShade.Material(network.material)
    mdl = _surface(material, "mdl")
    name = "" if mdl is None else mdl_name(mdl)
    if mdl is not None and name:
        network.visited.add(mdl.GetPath())
        known = read_mdl(network, mdl, name)
        if known is not None:
            return known
    universal = _surface(material, "")
    if universal is not None and shader_id(universal) == "UsdPreviewSurface":
        network.visited.add(universal.GetPath())
        return read_preview_surface(network, universal)
    for surface in (universal, _surface(material, "mtlx")):
        if surface is not None and shader_id(surface) in SURFACES:
            network.visited.add(surface.GetPath())
            return read_material_x(network, surface)
    surface = mdl or universal or _surface(material, "mtlx")
    name = name or (shader_id(surface) if surface is not None else "")
    file = mdl_file(mdl) if mdl is not None else ""
    name += f" of {file}" if "/" in file else ""
    what = f"its surface shader '{name}' is not supported" if surface is not None else "it has no surface shader"
    errors.warn_once(
        f"{network.material.GetPath()}: {what}; the displayColor of each mesh is used. Give the material a "
        f"UsdPreviewSurface or an OmniPBR, or reference its MaterialX as USD."
    )
    return None


def _surface(material: UsdShade.Material, context: str) -> UsdShade.Shader | None:
    """The surface shader of exactly this render context ("" is universal)."""
    output = material.GetSurfaceOutput(context) if context else material.GetSurfaceOutput()
    if not output:
        return None
    for attribute in output.GetValueProducingAttributes():
        shader = UsdShade.Shader(attribute.GetPrim())
        if shader:
            return shader
    return None


class MaterialTable:
    """Makes rows of `scene.MATERIAL`, each once for as long as its material stays."""

    def __init__(self) -> None:
        # Indices of its textures, and the bytes of the row.
        self._rows: dict[Material, tuple[tuple[int | None, ...], bytes]] = {}

    def build(
        self, materials: Sequence[Material], pool: TexturePool, progress: Progress | None = None
    ) -> tuple[np.ndarray, list[Texture]]:
        """Return one row for each material, and the textures that the rows refer to."""
        uses = dict.fromkeys(use for material in materials for use in material.textures)
        textures, indices = pool.load(uses, progress)
        before, self._rows = self._rows, {}
        for material in materials:
            used = tuple(indices.get(use) for use in material.textures)
            row = before.get(material)
            if row is None or row[0] != used:
                row = used, np.array(_row(material, indices), MATERIAL).tobytes()
            self._rows[material] = row
        table = b"".join(self._rows[material][1] for material in materials)
        return np.frombuffer(table, MATERIAL).copy(), textures


# Largest constants; those in neither table end at 1.
_HIGHEST = {"base_color": MAX_COLOR, "emission": MAX_EMISSION}
_UNLIMITED = ("ior", "thin", "normal_scale", "detail_scale")


def _row(material: Material, indices: dict[TextureUse, int]) -> tuple:
    """The values of a row of `MATERIAL`: of an `Input` x those of x, x_texture and x_channel, else of the same name."""
    values: dict[str, object] = {}
    for name, texture_column, channel_column in _FIELDS:
        value = getattr(material, name)
        if isinstance(value, Input):
            texture = NO_TEXTURE if value.texture is None else indices.get(value.texture, NO_TEXTURE)
            values[name] = _constant(material.name, name, value, textured=texture != NO_TEXTURE)
            values[texture_column], values[channel_column] = texture, value.channel
        elif name in _COLUMNS:
            values[name] = value if name in _UNLIMITED else _unit(value)
        else:
            values[texture_column] = NO_TEXTURE if value is None else indices.get(value, NO_TEXTURE)
    return tuple(map(values.__getitem__, _COLUMNS))


def _constant(material: str, name: str, value: Input, *, textured: bool) -> float | tuple[float, ...]:
    """The constant of an input within its limits; beside a texture, a scalar may be any factor > 0."""
    constant = value.value if value.texture is None or textured or value.fallback is None else value.fallback
    if name in _HIGHEST:
        highest = _HIGHEST[name]
        if max(constant) > highest:
            errors.warn_once(
                f"{material}: a color of {max(constant):g} is more than 32-bit numbers can follow from surface to "
                f"surface; {highest:g} is used. Correct it."
            )
        return tuple(min(max(number, 0.0), highest) for number in constant)
    if _COLUMNS[name].shape:
        return tuple(map(_unit, constant))
    return max(constant[0], 0.0) if textured else _unit(constant[0])


def _unit(value: float) -> float:
    return min(max(value, 0.0), 1.0)
