"""The first xform ops of many prims, such as have just been created, in one change."""

from collections.abc import Mapping, Sequence

from pxr import Gf, Sdf, Usd, UsdGeom, Vt

_T = Sdf.ValueTypeNames
_TYPES = {"translate": _T.Double3, "rotateXYZ": _T.Float3, "scale": _T.Float3}


_IDENTITY = {"translate": Gf.Vec3d(0), "rotateXYZ": Gf.Vec3f(0), "scale": Gf.Vec3f(1)}


def author_first_pose(spec: Sdf.PrimSpec, pose: Mapping[str, Sequence[float]]) -> None:
    """Give a prim of a layer that has no ops ops: translate, rotateXYZ and scale of `pose`, or identities."""
    for op, identity in _IDENTITY.items():
        Sdf.AttributeSpec(spec, f"xformOp:{op}", _TYPES[op]).default = type(identity)(*pose.get(op, identity))
    order = Sdf.AttributeSpec(spec, "xformOpOrder", _T.TokenArray, Sdf.VariabilityUniform)
    order.default = Vt.TokenArray([f"xformOp:{op}" for op in _IDENTITY])


def add_first_ops(prims: Sequence[Usd.Prim], layer: Sdf.Layer, ops: Sequence[str]) -> None:
    """Add ops without values to those of some prims of one stage that have none, as `xform_ops.author_pose` does.

    Args:
        layer: that of the edit target, where paths are those of the stage.
        ops: of "translate", "rotateXYZ", "scale" those that are added, in this order.
    """
    names = [f"xformOp:{op}" for op in ops]
    # A batch may hold prims of several stages, whose paths may be equal.
    stage = prims[0].GetStage() if prims else None
    bare = dict.fromkeys(prim.GetPath() for prim in prims if prim.GetStage() == stage and _is_bare(prim, names))
    order = Vt.TokenArray(names)
    with Sdf.ChangeBlock():
        for path in bare:
            for name, op in zip(names, ops):
                Sdf.JustCreatePrimAttributeInLayer(layer, path.AppendProperty(name), _TYPES[op])
            at = path.AppendProperty("xformOpOrder")
            Sdf.JustCreatePrimAttributeInLayer(layer, at, _T.TokenArray, Sdf.VariabilityUniform)
            layer.GetAttributeAtPath(at).default = order


def _is_bare(prim: Usd.Prim, names: Sequence[str]) -> bool:
    """Whether a prim can get ops and has neither any nor attributes of their names."""
    if not prim or prim.IsInstanceProxy() or prim.IsInPrototype() or not prim.IsA(UsdGeom.Xformable):
        return False
    return not prim.GetAttribute("xformOpOrder").HasAuthoredValue() and not any(map(prim.HasAttribute, names))
