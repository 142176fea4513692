"""Values of attributes that differ between many worlds of one stage, without a stage for each.

The stage is that of world 0. Of an attribute that differs, the values of all worlds are one array; all others are as on
the stage. `author` writes those of one world to the stage.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import takewhile
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.errors import Unsupported
from usdsdg.stage.poses.rotations import ROTATION_ORDERS, matrix_from_euler, matrix_from_quat
from usdsdg.stage.poses.transforms import as_array
from usdsdg.stage.poses.xform_ops import local_translation

Array = NDArray[Any]
# NumPy's types of the numbers of USD's value types.
_SCALARS = {
    "bool": np.bool_, "int": np.int32, "half": np.float16, "float": np.float32, "double": np.float64,
}  # fmt: skip
_OPS = UsdGeom.XformOp
_EULER = {getattr(_OPS, f"TypeRotate{order}"): order for order in ROTATION_ORDERS}
_SINGLE = {getattr(_OPS, f"TypeRotate{axis}"): "XYZ".index(axis) for axis in "XYZ"}
# Ops of one axis: the op of all three, the axis, and the number of the two others.
_ONE_AXIS = {
    getattr(_OPS, f"Type{name}{axis}"): (getattr(_OPS, f"Type{name}"), "XYZ".index(axis), rest)
    for name, rest in (("Translate", 0.0), ("Scale", 1.0))
    for axis in "XYZ"
}
_ABOUT_ORIGIN = frozenset(
    value for name, value in vars(_OPS).items() if name.startswith(("TypeRotate", "TypeScale", "TypeOrient"))
)


class Targets:
    """Attributes of one type, of which values are set together.

    Raises:
        ValueError: the types differ, or hold no numbers.
    """

    def __init__(self, attributes: Sequence[Usd.Attribute]) -> None:
        self.stage = attributes[0].GetStage() if attributes else None
        self.paths = [attribute.GetPrimPath() for attribute in attributes]
        self.names = [attribute.GetName() for attribute in attributes]
        types = {dtype_of(attribute) for attribute in attributes}
        if len(types) != 1 or None in types:
            raise ValueError("the attributes are not of one type that holds numbers")
        self.dtype = types.pop()


class OpLayouts:
    """The xform ops of prims, looked up once, and again where a prim has others."""

    def __init__(self) -> None:
        self._known: dict[Sdf.Path, tuple[Any, list[UsdGeom.XformOp]]] = {}

    def ops(self, prim: Usd.Prim) -> list[UsdGeom.XformOp]:
        """Return the ops of a prim in order."""
        path, attribute = prim.GetPath(), prim.GetAttribute("xformOpOrder")
        order = attribute.Get() if attribute else None
        known = self._known.get(path)
        if known is None or known[0] != order or (known[1] and not known[1][0].GetAttr()):
            known = self._known[path] = (order, UsdGeom.Xformable(prim).GetOrderedXformOps())
        return known[1]


class WorldValues:
    """Values in worlds, by prim path and name of the attribute.

    Attributes:
        count: how many worlds there are.
        time: at which what does not differ is read.
        values: (worlds, ...) arrays, in the precision of the attribute.
        unseen: as `values`, of attributes that a layer above the edit target decides, so that nothing shows them.
        unseen_from: by prim path and name, the first world that writes such an attribute; others from the first on.
        sources: what has drawn the values of a prim, for messages.
        steady: prim path and name of the attributes that every frame writes anew.
        read_from_stage: prim path and name of the attributes that were read before they were set, if at all.
        only_independent: whether the values are of use only where no world follows from another.
    """

    def __init__(
        self, count: int, time: Usd.TimeCode = Usd.TimeCode.Default(), *, only_independent: bool = False  # noqa: B008
    ) -> None:  # fmt: skip
        self.count, self.time, self.only_independent = count, time, only_independent
        self.values: dict[Sdf.Path, dict[str, Array]] = {}
        self.unseen: dict[Sdf.Path, dict[str, Array]] = {}
        self.unseen_from: dict[tuple[Sdf.Path, str], int] = {}
        self.sources: dict[Sdf.Path, str] = {}
        self.steady: frozenset[tuple[Sdf.Path, str]] = frozenset()
        self.read_from_stage: set[tuple[Sdf.Path, str]] = set()
        self._reads: set[tuple[Sdf.Path, str]] = set()
        self._writes: set[tuple[Sdf.Path, str]] = set()
        self._above: list[Sdf.Layer] | None = None  # layers that are stronger than the one that frames write to

    def set(self, attribute: Usd.Attribute, values: Array, source: str) -> None:
        """Set the values of an attribute, (worlds, ...) in the shape that USD gives; later calls win.

        Raises:
            Unsupported: values of its type cannot differ between worlds.
        """
        path = attribute.GetPath()
        dtype = dtype_of(attribute)
        if dtype is None:
            raise Unsupported(
                f"{path}: values of type {attribute.GetTypeName()} cannot differ between worlds. Run without --worlds."
            )
        self._set(attribute.GetStage(), path, np.asarray(values).astype(dtype), source)

    def set_block(self, targets: Targets, block: Array, source: str) -> None:
        """Set the values of many attributes, (worlds, attributes, ...), as `set` does."""
        rounded = block.astype(targets.dtype)
        for k, (path, name) in enumerate(zip(targets.paths, targets.names)):
            self._set(targets.stage, path.AppendProperty(name), rounded[:, k], source)

    def set_visible(self, prim: Usd.Prim, visible: Array, source: str) -> None:
        """Set in which worlds a prim is shown, (worlds,) bool."""
        self._set(prim.GetStage(), prim.GetPath().AppendProperty("visibility"), visible, source)

    def _set(self, stage: Usd.Stage | None, attribute: Sdf.Path, values: Array, source: str) -> None:
        if self._above is None:
            self._above = [] if stage is None else _layers_above_edit_target(stage)
        path, name = attribute.GetPrimPath(), attribute.name
        if any(_decides(layer, attribute) for layer in self._above):
            self.unseen.setdefault(path, {})[name] = values
            return
        self.values.setdefault(path, {})[name] = values
        self.sources[path] = source
        self._writes.add((path, name))

    def take_uses(self) -> tuple[frozenset[tuple[Sdf.Path, str]], frozenset[tuple[Sdf.Path, str]]]:
        """Return which attributes were read, and which were set, since the last call: (prim path, name) of each."""
        uses = frozenset(self._reads), frozenset(self._writes)
        self._reads.clear()
        self._writes.clear()
        return uses

    def refusal(self, path: Sdf.Path, error: Exception) -> Unsupported:
        """Return why values of a prim, or of one above it, cannot differ, with what has drawn them and the remedy."""
        source = next((self.sources[each] for each in reversed(path.GetPrefixes()) if each in self.sources), "a node")
        return Unsupported(f"worlds: {source}: {error}. Leave it out, or run without worlds.")

    def of(self, path: Sdf.Path) -> dict[str, Array]:
        """Return the values of a prim's attributes by name; none for a prim that is the same in all worlds."""
        return self.values.get(path, {})

    def held(self, prim: Usd.Prim, name: str) -> Array | None:
        """Return the values of one attribute of a prim; None where it is the same in all worlds."""
        path = prim.GetPath()
        self._reads.add((path, name))
        held = self.of(path).get(name)
        if held is None:
            self.read_from_stage.add((path, name))
        return held

    def moved(self) -> list[Sdf.Path]:
        """Return the prims whose local transforms differ."""
        return [path for path, values in self.values.items() if any(name.startswith("xformOp:") for name in values)]

    def move(self, prim: Usd.Prim) -> bool:
        """Return whether a prim, or one above it, has a local transform that differs."""
        return any(name.startswith("xformOp:") for path in prim.GetPath().GetPrefixes() for name in self.of(path))

    def translation(self, prim: Usd.Prim) -> Array:
        """(worlds or 1, 3) float64, the prim's translation in its parent's space."""
        held = self.held(prim, "xformOp:translate")
        return np.asarray(local_translation(prim) if held is None else held, np.float64).reshape(-1, 3)

    def local_matrices(self, prim: Usd.Prim) -> Array:
        """(worlds, 4, 4) float64, the prim's local transforms for row vectors; (1, 4, 4) if they are the same."""
        return self.local_matrices_of([prim])[:, 0]

    def local_matrices_of(
        self, prims: Sequence[Usd.Prim], layouts: OpLayouts | None = None, *, of_origins: bool = False
    ) -> Array:
        """(worlds or 1, prims, 4, 4) `local_matrices` of many prims; those with the same ops are computed together.

        of_origins: only their last rows count, so that ops which turn and scale about the origin are not read.
        """
        layouts = OpLayouts() if layouts is None else layouts
        groups: dict[tuple, list[tuple[int, list[Any]]]] = {}
        for row, prim in enumerate(prims):
            ops = layouts.ops(prim)
            if of_origins:
                ops = ops[: len(ops) - len(list(takewhile(_keeps_origin, reversed(ops))))]
            drawn = [self.held(prim, str(op.GetAttr().GetName())) for op in ops]
            if inverse := next((op for op, own in zip(ops, drawn) if op.IsInverseOp() and own is not None), None):
                raise Unsupported(f"{prim.GetPath()}: {inverse.GetName()} cannot differ between worlds")
            kind = tuple((op.GetOpType(), values is not None) for op, values in zip(ops, drawn))
            given = [op.GetOpTransform(self.time) if values is None else values for op, values in zip(ops, drawn)]
            groups.setdefault(kind, []).append((row, given))
        worlds = self.count if any(differs for kind in groups for _, differs in kind) else 1
        matrices = np.empty((worlds, len(prims), 4, 4))
        for kind, members in groups.items():
            rows = [row for row, _ in members]
            columns = zip(*(given for _, given in members)) if kind else ()
            matrix: Array | None = None
            for (op_type, differs), column in zip(kind, columns):
                if differs:
                    matrix = applied(op_type, np.stack(column, 1), matrix)
                    continue
                same = np.array([as_array(each) for each in column])
                if matrix is None:
                    matrix = same[None]
                elif not (same == np.eye(4)).all():
                    matrix = same @ matrix
            matrices[:, rows] = np.eye(4) if matrix is None else matrix
        return matrices

    def parent_to_world(self, prim: Usd.Prim) -> Array:
        """(worlds, 4, 4) or (1, 4, 4) float64, from the space of the prim's local transform to the world."""
        matrix: Array = np.eye(4)[None]
        while not (parent := prim.GetParent()).IsPseudoRoot():
            if UsdGeom.Xformable(prim) and UsdGeom.Xformable(prim).GetResetXformStack():
                break
            prim = parent
            if UsdGeom.Xformable(prim):
                matrix = matrix @ self.local_matrices(prim)
        return matrix

    def local_to_world(self, prim: Usd.Prim) -> Array:
        """(worlds, 4, 4) or (1, 4, 4) float64, from the prim's own space to the world."""
        if not UsdGeom.Xformable(prim):
            return self.parent_to_world(prim)
        return self.local_matrices(prim) @ self.parent_to_world(prim)

    def origin_to_world(self, prim: Usd.Prim) -> Array:
        """(worlds, 3) or (1, 3) float64, the origin of the prim's own space in the world."""
        matrices = self.parent_to_world(prim)
        if UsdGeom.Xformable(prim):
            matrices = self.local_matrices_of([prim], of_origins=True)[:, 0] @ matrices
        return matrices[:, 3, :3]

    def author(self, stage: Usd.Stage, world: int) -> None:
        """Author the values of one world in the edit target of the stage."""
        with Sdf.ChangeBlock():
            for path, values in (*self.values.items(), *self.unseen.items()):
                prim = stage.GetPrimAtPath(path)
                for name, column in values.items():
                    if world >= self.unseen_from.get((path, name), 0):
                        _author(prim.GetAttribute(name), column[world])

    def author_last(self, stage: Usd.Stage, *, steady: bool) -> None:
        """Author the values of the last world where the stage has those of the first; what differs from these stays.

        steady: also those that every frame writes anew.
        """
        changed = []
        for path, values in self.values.items():
            names = values if steady else [name for name in values if (path, name) not in self.steady]
            for name in names:
                first, last = values[name][0], values[name][-1]
                attribute = stage.GetPrimAtPath(path).GetAttribute(name)
                if attribute and not np.array_equal(first, last) and _is_about(number_of(attribute, self.time), first):
                    changed.append((attribute, last))
        with Sdf.ChangeBlock():
            for attribute, value in changed:
                _author(attribute, value)


def _layers_above_edit_target(stage: Usd.Stage) -> list[Sdf.Layer]:
    """Return the layers with opinions that are stronger than those of the edit target; none if it is no such layer."""
    layers, target = stage.GetLayerStack(), stage.GetEditTarget().GetLayer()
    return [layer for layer in layers[: layers.index(target)] if not layer.empty] if target in layers else []


def _decides(layer: Sdf.Layer, attribute: Sdf.Path) -> bool:
    spec = layer.GetAttributeAtPath(attribute)
    return spec is not None and (spec.HasDefaultValue() or spec.HasInfo("timeSamples"))


def _keeps_origin(op: UsdGeom.XformOp) -> bool:
    return op.GetOpType() in _ABOUT_ORIGIN


def _is_about(value: Any, other: Array) -> bool:
    """Whether numbers are the same but for their rounding, which differs between actions and arrays."""
    return np.shape(value) == np.shape(other) and np.allclose(value, other, rtol=1e-5, atol=1e-6)


def number_of(attribute: Usd.Attribute, time: Usd.TimeCode) -> Any:
    """Return the value of an attribute as `WorldValues` holds it, of one world; None if it has none."""
    if attribute.GetName() == "visibility":
        return np.bool_(attribute.Get(time) != UsdGeom.Tokens.invisible)
    value = attribute.Get(time)
    if isinstance(value, (Gf.Quatd, Gf.Quatf, Gf.Quath)):
        value = (*value.GetImaginary(), value.GetReal())
    return None if value is None else np.asarray(value, dtype_of(attribute))


def dtype_of(attribute: Usd.Attribute) -> Any:
    """Return NumPy's type of the numbers of an attribute; None for types that hold no numbers."""
    kind = attribute.GetTypeName()
    scalar = str(kind.scalarType.cppTypeName) if kind.isArray else str(kind.cppTypeName)
    if scalar in _SCALARS:
        return _SCALARS[scalar]
    letter = scalar[-1:] if scalar.startswith("Gf") else ""
    return {"d": np.float64, "f": np.float32, "h": np.float16, "i": np.int32}.get(letter)


def _author(attribute: Usd.Attribute, value: Array) -> None:
    if attribute.GetName() == "visibility":
        attribute.Set(UsdGeom.Tokens.inherited if value else UsdGeom.Tokens.invisible)
    else:
        attribute.Set(_usd_value(attribute, value))


def _usd_value(attribute: Usd.Attribute, value: Array) -> Any:
    kind = attribute.GetTypeName()
    example = kind.defaultValue
    if isinstance(example, (Gf.Quatd, Gf.Quatf, Gf.Quath)):
        x, y, z, w = value.tolist()
        return type(example)(w, x, y, z)
    if kind.isArray:
        return type(example).FromNumpy(np.ascontiguousarray(value))
    return type(example)(*value.tolist()) if value.ndim else value.item()


def applied(kind: Any, values: Array, matrix: Array | None) -> Array:
    """Return the products of the matrices of xform ops of a type with `matrix`, for row vectors.

    values: (worlds, prims, ...), quaternions as x, y, z, w. matrix: (worlds or 1, prims, 4, 4); None: the identity.
    """
    if kind in _ONE_AXIS:
        kind, axis, rest = _ONE_AXIS[kind]
        values = np.where(np.arange(3) == axis, np.asarray(values, np.float64)[..., None], rest)
    worlds, prims = values.shape[:2]
    if kind == _OPS.TypeTransform:
        own = values.astype(np.float64)
        return own if matrix is None else own @ matrix
    product = np.empty((worlds, prims, 4, 4))
    product[:] = np.eye(4) if matrix is None else matrix
    numbers = np.asarray(values, np.float64)
    if kind == _OPS.TypeTranslate:
        product[..., 3, :3] += numbers if matrix is None else (numbers[..., None, :] @ matrix[..., :3, :3])[..., 0, :]
    elif kind == _OPS.TypeScale:
        product[..., :3, :3] *= numbers[..., None]
    elif matrix is None or _only_moves(matrix):
        product[..., :3, :3] = _rotations(kind, numbers)
    else:
        product[..., :3, :3] = _rotations(kind, numbers) @ matrix[..., :3, :3]
    return product


def _only_moves(matrix: Array) -> bool:
    """Whether matrices have no rotation and no scale."""
    return bool((matrix[..., :3, :3] == np.eye(3)).all())


def _rotations(kind: Any, values: Array) -> Array:
    if kind == _OPS.TypeOrient:
        return matrix_from_quat(values)
    if kind in _SINGLE:
        angles = np.zeros((*values.shape, 3))
        angles[..., _SINGLE[kind]] = values
        return matrix_from_euler(angles, "XYZ")
    return matrix_from_euler(values, _EULER[kind])
