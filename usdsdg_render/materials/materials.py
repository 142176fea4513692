"""Read UsdShade materials, and cache them by prim path."""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from pxr import Sdf, Usd, UsdShade

from usdsdg import errors
from usdsdg.stage.changes import is_below
from usdsdg.stage.prims.handles import Handles
from usdsdg_render.materials.material_x import SURFACES, read_material_x
from usdsdg_render.materials.mdl.material import mdl_file, mdl_name, read_mdl
from usdsdg_render.materials.network import Network, shader_id
from usdsdg_render.materials.plain_inputs import PlainInput
from usdsdg_render.materials.preview_surface import PREVIEW_SURFACES, read_preview_surface
from usdsdg_render.materials.shading import Material
from usdsdg_render.usd.authored_values import as_floats
from usdsdg_render.usd.prim_kinds import UNREAD


@dataclass(slots=True)
class MaterialEntry:
    """A material, and what it was read from."""

    material: Material | None  # None: its surface shader is missing or unknown
    network: Network
    shared_as: tuple | None
    path: Sdf.Path  # at which it was read: the prims of the network are those below, also for others that have it
    users: int = 0  # paths that have it


class Update(NamedTuple):
    """A material of which some fields were read again."""

    before: Material
    after: Material
    names: Collection[str]


class MaterialLibrary:
    """Cache of materials by prim path, and by the specs that define them where these determine everything.

    Each reference to an asset has its own material prims, but most are composed of the same specs and share an entry.
    An edit of one of them adds a spec, so that it no longer shares.

    Args:
        handles: gets a `PlainInput` or `UNREAD` for properties that were changed; they are forgotten when that may not
            hold any more.
    """

    def __init__(self, stage: Usd.Stage, handles: Handles) -> None:
        self._handles = handles
        self._stage = stage
        self._by_path: dict[Sdf.Path, MaterialEntry] = {}
        self._by_specs: dict[tuple, MaterialEntry] = {}
        self._readers: dict[Sdf.Path, set[Sdf.Path]] = {}  # the materials that depend on each prim
        self._unread: dict[Sdf.Path, bool] = {}  # `_is_unread_shader`, until other materials are read
        self._dropped: dict[Sdf.Path, Material | None] = {}  # as they were before they were dropped

    def read(self, prim: Usd.Prim) -> Material | None:
        """Read the material at `prim`; None (with a warning) when its surface shader is missing or unknown."""
        return self.at(prim.GetPath())

    def at(self, path: Sdf.Path) -> Material | None:
        """Return `read` of the prim at a path."""
        entry = self._by_path.get(path)
        if entry is None:
            prim = self._stage.GetPrimAtPath(path)
            specs = _specs(prim)
            entry = self._by_specs.get(specs)
            if entry is None:
                entry = _read(prim, specs, self._dropped.get(path))
                if entry.shared_as is not None:
                    self._by_specs[specs] = entry
            self._by_path[path] = entry
            self._forget_inputs()
            entry.users += 1
            for visited in entry.network.visited:
                self._readers.setdefault(visited, set()).add(path)
            self._dropped.pop(path, None)
        return entry.material

    def invalidate(self, changed: Collection[Sdf.Path], roots: Collection[Sdf.Path]) -> set[Sdf.Path]:
        """Drop and return the materials that depend on a prim of `changed`, or on one at or below `roots`.

        A shading prim that no material is known to depend on may be part of any network, so then all are dropped.
        """
        if not changed and not roots:
            return set()
        known, readers = self._by_path, self._readers
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

    def update(self, changed: Mapping[Sdf.Path, Collection[str]]) -> tuple[dict[Sdf.Path, Update], set[Sdf.Path]]:
        """Read the fields of materials again that depend on inputs of shading prims whose values may have changed.

        Args:
            changed: names of inputs by prim.

        Returns:
            Materials that were updated, by path, and those of the prims that `invalidate` must be told of instead.
        """
        updates: dict[Sdf.Path, Update] = {}
        others: set[Sdf.Path] = set()
        for prim, names in changed.items():
            found = self._readers.get(prim, ())
            if not found and self._is_unread_shader(prim):
                self._handles.note(map(prim.AppendProperty, names), UNREAD)
                continue
            entries = [(path, self._by_path[path]) for path in found]
            if not entries or any(
                entry.users > 1 or entry.path != path or entry.material is None for path, entry in entries
            ):
                others.add(prim)
                continue
            for path, entry in entries:
                fields = entry.network.changed_fields(prim, names)
                if fields is None:
                    others.add(prim)
                    continue
                self._replace(path, entry, fields, updates)
                if len(entries) == 1:
                    self._note_plain_inputs(prim, names, path, entry)
        return updates, others

    def _replace(
        self, path: Sdf.Path, entry: MaterialEntry, fields: dict[str, Any], updates: dict[Sdf.Path, Update]
    ) -> None:
        """Replace fields of a material, and note that in `updates`."""
        before, earlier = entry.material, updates.get(path)
        assert before is not None  # whoever calls this has read some of its fields
        after = entry.material = before.with_fields(fields)
        self._unshare(entry)
        if earlier is None:
            updates[path] = Update(before, after, fields)
        else:
            updates[path] = Update(earlier.before, after, {*fields, *earlier.names})

    def _note_plain_inputs(self, prim: Sdf.Path, names: Iterable[str], path: Sdf.Path, entry: MaterialEntry) -> None:
        for name in names:
            reading, written = entry.network.readings[prim, name], [prim.AppendProperty(name)]
            if reading.alone is None:
                self._handles.drop(written)
            else:
                self._handles.note(written, PlainInput(prim, name, path, entry, reading))

    def _forget_inputs(self) -> None:
        """Forget which material reads which input, since others are read now."""
        self._unread.clear()
        self._handles.forget()

    def _is_unread_shader(self, path: Sdf.Path) -> bool:
        """Whether a shader without readers belongs to a material that was read without it."""
        if path not in self._unread:
            owner = next((each for each in path.GetPrefixes() if each in self._by_path), None)
            entry = None if owner is None else self._by_path[owner]
            is_read = entry is not None and entry.material is not None and entry.path == owner
            self._unread[path] = is_read and self._stage.GetPrimAtPath(path).GetTypeName() == "Shader"
        return self._unread[path]

    def _drop(self, paths: Iterable[Sdf.Path]) -> None:
        """Drop entries, shared ones too: edits of the prims that share them are not tracked."""
        for path in paths:
            entry = self._by_path.pop(path)
            self._forget_inputs()
            self._dropped[path] = entry.material
            entry.users -= 1
            for visited in entry.network.visited:
                self._readers[visited].discard(path)
                if not self._readers[visited]:
                    del self._readers[visited]
            self._unshare(entry)

    def _unshare(self, entry: MaterialEntry) -> None:
        if entry.shared_as is not None:
            self._by_specs.pop(entry.shared_as, None)
            entry.shared_as = None

    def _is_shading(self, path: Sdf.Path) -> bool:
        prim = self._stage.GetPrimAtPath(path)
        return bool(prim) and not prim.IsA(UsdShade.Material) and prim.IsA(UsdShade.NodeGraph)

    def keep_only(self, paths: set[Sdf.Path]) -> None:
        """Drop all materials but these, which are still bound."""
        self._drop(path for path in list(self._by_path) if path not in paths)
        self._dropped = {path: material for path, material in self._dropped.items() if path in paths}


def _specs(prim: Usd.Prim) -> tuple:
    return tuple((spec.layer.identifier, spec.path) for spec in prim.GetPrimStack())


def _read(prim: Usd.Prim, specs: tuple, before: Material | None) -> MaterialEntry:
    """Read a material; one that equals `before` is that object, by which others know it."""
    network = Network(prim)
    material = _read_surface(network)
    _warn_of_displacement(network)
    if material == before:
        material = before
    own = prim.GetPath()
    closed = all(path.HasPrefix(own) for path in network.visited) and not any(map(_is_its_own, Usd.PrimRange(prim)))
    return MaterialEntry(material, network, specs if closed else None, own)


def _is_its_own(prim: Usd.Prim) -> bool:
    """Whether prims that are composed of the same specs may have other values, or have them after an edit."""
    # Layer offsets and value clips may give each reference to one layer its own time.
    return _has_arcs(prim) or any(each.ValueMightBeTimeVarying() for each in prim.GetAuthoredAttributes())


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
    universal, material_x = _surface(material, ""), _surface(material, "mtlx")
    for surface in (universal, material_x):
        if surface is not None and shader_id(surface) in PREVIEW_SURFACES:
            network.visited.add(surface.GetPath())
            return read_preview_surface(network, surface)
        if surface is not None and shader_id(surface) in SURFACES:
            network.visited.add(surface.GetPath())
            return read_material_x(network, surface)
    surface = mdl or universal or material_x
    name = name or (shader_id(surface) if surface is not None else "")
    file = mdl_file(mdl) if mdl is not None else ""
    name += f" of {file}" if "/" in file else ""
    if surface is None:
        what = "it has no surface shader"
    else:
        what = f"its surface shader '{name}' is not supported" if name else f"{surface.GetPath()} has no info:id"
    errors.warn_once(
        f"{network.material.GetPath()}: {what}; the displayColor of each mesh is used. Give the material a "
        f"UsdPreviewSurface or an OmniPBR, or reference its MaterialX as USD."
    )
    return None


def _warn_of_displacement(network: Network) -> None:
    """Warn of a displacement by a shader of its own; that of a surface shader is for who reads it."""
    material = UsdShade.Material(network.material)
    for context in ("", "mdl", "mtlx"):
        shader = _terminal(material.GetDisplacementOutput, context)
        surface = _surface(material, context)
        if shader is None or (surface is not None and surface.GetPath() == shader.GetPath()):
            continue
        network.visited.add(shader.GetPath())
        source = network.source(shader, "displacement")
        if source.shader is not None or any(as_floats(network.value(shader, "displacement"), 1) or ()):
            network.warn(shader, "displacement is not supported and is ignored. Bake it into the mesh.")


def _surface(material: UsdShade.Material, context: str) -> UsdShade.Shader | None:
    """The surface shader of exactly this render context ("" is universal)."""
    return _terminal(material.GetSurfaceOutput, context)


def _terminal(output_of: Callable[..., UsdShade.Output], context: str) -> UsdShade.Shader | None:
    output = output_of(context) if context else output_of()
    if not output:
        return None
    for attribute in output.GetValueProducingAttributes():
        shader = UsdShade.Shader(attribute.GetPrim())
        if shader:
            return shader
    return None
