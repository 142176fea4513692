"""The table of materials: each has a row for as long as it is used, so that an edit writes its own row only."""

import heapq
from collections.abc import Collection, Hashable, Iterable, Sequence

import numpy as np

from usdsdg_render.images.textures import Progress, TexturePool, TextureUse
from usdsdg_render.materials.display_color import DisplayColor
from usdsdg_render.materials.material_rows import PLAIN, display_color_rows, material_row, write_field
from usdsdg_render.materials.plain_inputs import FieldEdits
from usdsdg_render.materials.shading import Input, Material
from usdsdg_render.scene.scene import MATERIAL, Texture

AnyMaterial = Material | DisplayColor


class MaterialTable:
    """Rows of `scene.MATERIAL`, counted by their users. `write` fills those that were taken since the last call."""

    def __init__(self) -> None:
        self._rows = np.zeros(0, MATERIAL)
        self._materials: list[AnyMaterial | None] = []  # of each row; holding them keeps their ids from being reused
        self._users: list[int] = []
        self._row_of: dict[Hashable, int] = {}
        self._textures: dict[int, tuple[int | None, ...]] = {}  # indices in textured rows, as they were written
        self._indices: dict[TextureUse, int] = {}  # of all textures in use
        self._unused: list[int] = []  # heap of rows without users; some may have got one since
        self._queued: set[int] = set()  # the rows in that heap
        self._stale: list[int] = []  # rows to be written
        self._released: list[int] = []  # rows that have lost their last user since the last `write`
        self._edited: dict[str, dict[int, None]] = {}  # rows by the field of them that changed
        self._must_load = True  # whether textures may have come or gone

    def __len__(self) -> int:
        return len(self._materials)

    def take(self, material: AnyMaterial) -> int:
        """Return the row of a material for one more user."""
        key = _key(material)
        row = self._row_of.get(key)
        if row is None:
            row = self._row_of[key] = self._free_row()
            self._materials[row] = material
            self._stale.append(row)
        self._users[row] += 1
        return row

    def release(self, rows: Iterable[int]) -> None:
        """Give rows back, once for each time that they were taken."""
        for row in rows:
            self._users[row] -= 1
            if not self._users[row]:
                if row not in self._queued:
                    self._queued.add(row)
                    heapq.heappush(self._unused, row)
                self._released.append(row)

    def recolor(self, rows: Sequence[int], colors: Sequence[DisplayColor]) -> bool:
        """Give rows of display colors, which have one user each, other ones.

        Returns:
            False, with nothing changed, where users share a row, or would.
        """
        before = [each for row in rows if isinstance(each := self._materials[row], DisplayColor)]
        after = set(colors)
        if len(before) < len(rows) or len(after) < len(rows) or any(self._users[row] != 1 for row in rows):
            return False
        if not (self._row_of.keys() & after).issubset(before):
            return False
        for color in before:
            del self._row_of[color]
        self._row_of.update(zip(colors, rows))
        for row, color in zip(rows, colors):
            self._materials[row] = color
        self._stale += rows
        return True

    def replace(self, before: Material, after: Material, names: Collection[str]) -> None:
        """Give the row of a material, where it has one, to another one that differs from it in these fields only."""
        row = self._row_of.pop(_key(before), None)
        if row is None:
            return
        self._row_of[_key(after)] = row
        self._materials[row] = after
        if all(_have_one_texture(getattr(before, name), getattr(after, name)) for name in names):
            for name in names:
                self._edited.setdefault(name, {})[row] = None
        else:
            self._stale.append(row)
            self._must_load = True

    def edit(self, edits: FieldEdits) -> None:
        """Write a field again that was set in place, of the materials that have a row."""
        rows = dict.fromkeys(map(self._row_of.get, map(id, edits.materials)))
        edited = self._edited.setdefault(edits.name, {})
        edited.update((row, None) for row in rows if row is not None)

    def load_again(self) -> None:
        """Ask for the textures of all rows at the next `write`, since their files have changed."""
        self._must_load = True

    def _free_row(self) -> int:
        while self._unused:
            row = heapq.heappop(self._unused)
            self._queued.discard(row)
            if not self._users[row]:
                self._forget(row)
                return row
        self._materials.append(None)
        self._users.append(0)
        return len(self._materials) - 1

    def _forget(self, row: int) -> None:
        material, self._materials[row] = self._materials[row], None
        if material is not None:
            del self._row_of[_key(material)]
            self._must_load |= self._textures.pop(row, None) is not None

    def write(self, pool: TexturePool, progress: Progress | None = None) -> tuple[np.ndarray, list[Texture] | None]:
        """Return all rows, and the textures that they refer to, None where these are the same as before.

        Rows without users hold a material that emits nothing and lets nothing pass.
        """
        stale, released = dict.fromkeys(self._stale), [row for row in self._released if not self._users[row]]
        self._stale, self._released = [], []
        if len(self._rows) < len(self._materials):
            grown = np.full(2 * len(self._materials), PLAIN)
            grown[: len(self._rows)] = self._rows
            self._rows = grown
        for row in released:
            self._forget(row)
        self._rows[released] = PLAIN
        colors = {row: each for row in stale if isinstance(each := self._materials[row], DisplayColor)}
        if colors:
            self._rows[list(colors)] = display_color_rows(list(colors.values()))
        textures = self._write_materials(stale, pool, progress)
        self._write_fields()
        return self._rows[: len(self._materials)].copy(), textures

    def _write_materials(
        self, stale: Iterable[int], pool: TexturePool, progress: Progress | None
    ) -> list[Texture] | None:
        """Write the stale rows of materials of other kinds, and those whose textures have other indices now."""
        materials = {row: each for row in stale if isinstance(each := self._materials[row], Material)}
        textures = None
        if self._must_load or any(material.textures for material in materials.values()):
            self._must_load = False
            textured = {row: m for row, m in enumerate(self._materials) if isinstance(m, Material) and m.textures}
            uses = dict.fromkeys(use for material in textured.values() for use in material.textures)
            textures, self._indices = pool.load(uses, progress)
            for row, material in textured.items():
                used = tuple(map(self._indices.get, material.textures))
                if self._textures.get(row) != used:
                    self._textures[row] = used
                    materials[row] = material
        for row, material in materials.items():
            self._rows[row] = material_row(material, self._indices)
        return textures

    def _write_fields(self) -> None:
        """Write the fields that changed in rows that keep their textures."""
        edited, self._edited = self._edited, {}
        for name, rows in edited.items():
            # A row may have been given away since.
            own = [(row, each) for row in rows if type(each := self._materials[row]) is Material]
            if own:
                write_field(self._rows, [row for row, _ in own], [each for _, each in own], name, self._indices)


def _key(material: AnyMaterial) -> Hashable:
    """What materials share a row by: display colors that are equal, and others that are the same."""
    return material if isinstance(material, DisplayColor) else id(material)


def _have_one_texture(before: object, after: object) -> bool:
    ours, other = _texture(before), _texture(after)
    return ours is other or ours == other


def _texture(value: object) -> object:
    """The texture of a field of a material."""
    return value.texture if isinstance(value, Input) else value if isinstance(value, TextureUse) else None
