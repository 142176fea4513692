"""Materials of the drawn gprims: bound or fallback, then rows and textures of the scene."""

from collections.abc import Collection, Iterable, Mapping, Sequence

import numpy as np
from pxr import Sdf, Usd

from usdsdg import errors
from usdsdg.stage.prims.handles import Handles
from usdsdg_render.images.textures import Progress, TexturePool
from usdsdg_render.lights.mesh_lights import emissive_material
from usdsdg_render.materials.binding_owners import BindingOwners
from usdsdg_render.materials.bindings import bound_materials
from usdsdg_render.materials.color_faults import warn_of_colors
from usdsdg_render.materials.color_textures import ColorTextures
from usdsdg_render.materials.display_color import (
    DisplayColor,
    display_colors,
    display_opacities,
    fallback_material,
)
from usdsdg_render.materials.material_table import AnyMaterial
from usdsdg_render.materials.materials import MaterialLibrary
from usdsdg_render.materials.plain_inputs import PlainInputs
from usdsdg_render.materials.shading import Material
from usdsdg_render.scene.scene import Prototype, Scene
from usdsdg_render.sync.gprims import Gprim, Gprims
from usdsdg_render.sync.invalidation import DirtySet
from usdsdg_render.sync.material_slots import MaterialSlots
from usdsdg_render.sync.plain_colors import PlainColors
from usdsdg_render.usd.prim_kinds import MESH, SHAPE


class GprimMaterials:
    """Reads the materials of gprims and keeps the material tables of one scene up to date with them."""

    def __init__(self, stage: Usd.Stage, scene: Scene, handles: Handles, progress: Progress | None) -> None:
        self.binding_owners = BindingOwners()
        self._stage = stage
        self._scene = scene
        self._progress = progress
        self._library = MaterialLibrary(stage, handles)
        self._plain_inputs = PlainInputs(handles)
        self._plain_colors = PlainColors(handles)
        self._textures = TexturePool()
        self._slots = MaterialSlots()
        self._colors = ColorTextures()
        self._recolored: list[Gprim] = []  # since the last `write`
        self._is_stale = False  # whether `write` must follow although all gprims have their materials

    @property
    def first_slots(self) -> Mapping[Sdf.Path, int]:
        """First material slot of each gprim, as last written."""
        return self._slots.first

    def invalidate(self, dirty: DirtySet, gprims: Gprims) -> bool:
        """Drop the materials that must be read again; whether there are any."""
        is_recolored = bool(dirty.plain_colors) and self._recolor(dirty)
        if not (dirty.materials or dirty.resynced or dirty.inputs or dirty.plain_inputs):
            return is_recolored
        stale = self._library.invalidate(dirty.materials, dirty.resynced)
        edits, unusual = self._plain_inputs.edit_materials(dirty.plain_inputs)
        for each in edits:
            gprims.keep_materials(each)
            self._slots.table.edit(each)
            self._is_stale = True
        inputs = {prim: set(names) for prim, names in dirty.inputs.items()}
        for each in unusual:
            inputs.setdefault(each.prim, set()).add(each.name)
        updates, others = self._library.update(inputs)
        if others:
            stale |= self._library.invalidate(others, ())
        if stale:
            gprims.invalidate_materials(stale)
        if updates:
            gprims.replace_materials(updates)
            for update in updates.values():
                self._slots.table.replace(*update)
            self._is_stale = True
        return bool(stale or updates or edits or is_recolored)

    def _recolor(self, dirty: DirtySet) -> bool:
        """Give gprims the materials of plain displayColors; whether there are any. `dirty` gets the others."""
        recolored, others = self._plain_colors.edit(dirty.plain_colors)
        dirty.colors.update(gprim.path for gprim in others)
        self._recolored += recolored
        self._is_stale |= bool(recolored)
        return bool(recolored)

    def look_at_files(self) -> bool:
        """Let textures be loaded again if a file of them has changed; whether it has."""
        if not self._textures.is_stale():
            return False
        self._slots.table.load_again()
        self._is_stale = True
        return True

    @property
    def are_written(self) -> bool:
        """Whether the scene has all materials as they were read."""
        return not self._is_stale

    def bind(self, gprims: Gprims) -> None:
        """Find the bound materials of gprims where they may have changed."""
        unbound = [gprim for gprim in gprims.drawn if not gprim.is_bound]
        asked = [prim for gprim in unbound for prim in (*gprim.subsets, gprim.prim)]
        found = iter(bound_materials(asked, self.binding_owners))
        for gprim in unbound:
            prims = [next(found) for _ in range(len(gprim.subsets) + 1)]
            bound = [None if prim is None else prim.GetPath() for prim in prims]
            if bound != gprim.bound:
                gprim.materials = None
            gprim.bound, gprim.is_bound = bound, True
        if unbound:
            gprims.forget_users()
            self._library.keep_only({path for g in gprims.known.values() for path in g.bound if path is not None})

    def read(self, gprims: Sequence[Gprim], time: Usd.TimeCode) -> None:
        """Read the material of each slot of gprims."""
        if not gprims:
            return
        bound = [[None if path is None else self._library.at(path) for path in gprim.bound] for gprim in gprims]
        shown = [g for g, own in zip(gprims, bound) if any(m is None or m.reads_display_color for m in own)]
        _read_shown(shown, time)
        for gprim, own in zip(gprims, bound):
            gprim.materials = [_resolved(gprim, time, material) for material in own]
            gprim.colored, gprim.averaged = _varying_slots(gprim, own)
            if gprim.is_light:
                whole = (m.material if isinstance(m, DisplayColor) else m for m in gprim.materials)
                gprim.materials = [emissive_material(material, gprim.prim) for material in whole]
            gprim.has_own_materials = any(a is not b and b is not None for a, b in zip(gprim.materials, own))
        self._plain_colors.note(gprim for gprim in shown if gprim.is_recolored)

    def apply_colors(self, changed: Iterable[Gprim], prototypes: Collection[int], time: Usd.TimeCode) -> None:
        """Give gprims the textures of their varying colors; warn of those that cannot have them, or not as authored.

        prototypes: ids of all prototypes of the scene.
        """
        for gprim in changed:
            if gprim.is_plain or gprim.prototype is None:
                continue
            materials, prototype = gprim.materials or [], gprim.prototype
            is_textured = gprim.kind == MESH and any(each.textures for each in materials)
            if prototype.colors is not None:
                for slot in gprim.colored:
                    materials[slot] = self._colors.apply(materials[slot], prototype)
                gprim.has_own_materials = True
            if gprim.color_varies:
                _warn_of_varying_color(gprim, prototype, time)
            if is_textured and not _has_uvs(prototype, () if prototype.colors is None else gprim.colored):
                _warn_of_missing_uvs(gprim.prim)
        self._colors.keep_only(set(prototypes))
        for use, texture in self._colors.textures():
            self._textures.keep(use, texture)

    def write(self, drawn: Sequence[Gprim], changed: Sequence[Gprim] | None) -> None:
        """Write the materials, material slots and textures of the scene.

        changed: the only gprims with other materials than before; None if others may be drawn.
        """
        scene, slots = self._scene, self._slots
        recolored, self._recolored = self._recolored, []
        if changed is None or not (slots.recolor(recolored) and slots.reassign(changed)):
            slots.assign(drawn)
        table, textures = slots.table.write(self._textures, self._progress)
        self._is_stale = False
        if textures is not None and (
            len(scene.textures) != len(textures) or any(a is not b for a, b in zip(scene.textures, textures))
        ):
            scene.textures = list(textures)
            scene.touch("textures")
        if not np.array_equal(slots.rows, scene.material_slots) or table.tobytes() != scene.materials.tobytes():
            scene.materials, scene.material_slots = table, slots.rows
            scene.touch("materials")


def _read_shown(gprims: Sequence[Gprim], time: Usd.TimeCode) -> None:
    """Read the displayColor and displayOpacity of gprims where they may have changed."""
    stale = [gprim for gprim in gprims if gprim.color is None]
    for gprim, color in zip(stale, display_colors([gprim.shown[0] for gprim in stale], time)):
        gprim.color = color
    stale = [gprim for gprim in gprims if gprim.opacity is None]
    for gprim, opacity in zip(stale, display_opacities([gprim.shown[1] for gprim in stale], time)):
        gprim.opacity = opacity


def _resolved(gprim: Gprim, time: Usd.TimeCode, material: Material | None) -> AnyMaterial:
    """The material with the gprim's primvars, or the fallback material."""
    if material is not None and material.primvar_inputs:
        material = material.with_primvars_of(gprim.prim, time)
    if material is not None and not material.reads_display_color:
        return material
    assert gprim.color is not None
    assert gprim.opacity is not None
    fallback = fallback_material(gprim.color, gprim.opacity)
    if material is None:
        return fallback
    # Without a displayColor the base color is the fallback of the reader.
    return material if gprim.color.value is None else material.with_base_color(fallback.color)


def _varying_slots(gprim: Gprim, bound: Sequence[Material | None]) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Slots that show a displayColor as it varies over the gprim, and those that show its mean.

    bound: the material of each slot as it is bound. Textures of it take the texture coordinates of its faces.
    """
    if not gprim.color_varies:
        return (), ()
    shown = [slot for slot, each in enumerate(bound) if each is None or each.reads_display_color]
    may_vary = [slot for slot in shown if gprim.kind != SHAPE and not getattr(bound[slot], "textures", ())]
    return tuple(may_vary), tuple(slot for slot in shown if slot not in may_vary)


def _warn_of_varying_color(gprim: Gprim, prototype: Prototype, time: Usd.TimeCode) -> None:
    """Warn of a displayColor that is not drawn as authored, where triangles show it."""
    by_mean = gprim.averaged if prototype.colors is not None else (*gprim.averaged, *gprim.colored)
    if np.isin(prototype.triangle_slots, (*by_mean, *gprim.colored)).any():
        warn_of_colors(gprim.prim, time, by_mean=bool(np.isin(prototype.triangle_slots, by_mean).any()))


def _has_uvs(prototype: Prototype, colored: tuple[int, ...]) -> bool:
    """Whether there are texture coordinates, or no triangles, beside those of the slots whose are of their colors."""
    uvs = prototype.uvs[~np.isin(prototype.triangle_slots, colored)] if colored else prototype.uvs
    return not len(uvs) or bool(uvs.any())


def _warn_of_missing_uvs(prim: Usd.Prim) -> None:
    st = prim.GetAttribute("primvars:st")
    if st and not st.GetMetadata("interpolation") and len(st.Get() or ()) > 1:
        why = "primvars:st has no interpolation, so one value counts for the whole mesh. Author vertex or faceVarying"
    else:
        why = "the mesh has no texture coordinates. Author primvars:st"
    errors.warn_once(f"{prim.GetPath()}: its material has textures, but they show one texel: {why}.")
