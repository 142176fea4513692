"""Keypoints of prims: named points in a prim's own frame, one attribute `usdsdg:keypoints:NAME` for each.

They move with the prim, are saved with the stage, come along with references and instances, and may have time samples.
"""

from collections.abc import Mapping, Sequence

from pxr import Gf, Sdf, Usd

from usdsdg import errors
from usdsdg.stage.attributes import remove_value

NAMESPACE = "usdsdg:keypoints"
_DEFAULT = Usd.TimeCode.Default()


def get_keypoints(prim: Usd.Prim, time: Usd.TimeCode = _DEFAULT) -> dict[str, tuple[float, float, float]]:
    """Return the keypoints of a prim at a time by name, in the order of the names [stage units, the prim's frame]."""
    found = {}
    for attribute in prim.GetAuthoredPropertiesInNamespace(NAMESPACE):
        value = attribute.Get(time) if isinstance(attribute, Usd.Attribute) else None
        if value is None:
            continue
        if not isinstance(value, (Gf.Vec3d, Gf.Vec3f, Gf.Vec3h)):
            errors.warn_once(
                f"{attribute.GetPath()}: {value} is not a point, so the keypoint is left out. Author point3d."
            )
            continue
        found[attribute.GetBaseName()] = (float(value[0]), float(value[1]), float(value[2]))
    return dict(sorted(found.items()))


def set_keypoints(prim: Usd.Prim, points: Mapping[str, Sequence[float]], *, replace: bool = False) -> None:
    """Set keypoints of a prim by name; with `replace` all others are removed.

    Raises:
        BadPrim: the prim is gone or lies inside an instance.
        ValueError: a name is not an identifier, or a point is not three numbers.
    """
    if not prim:
        raise errors.BadPrim(f"cannot set keypoints of {prim}: the prim does not exist any more")
    if prim.IsInstanceProxy() or prim.IsInPrototype():
        raise errors.BadPrim(
            f"cannot set keypoints of {prim.GetPath()}: it lies inside an instance; set them in the asset, or "
            "SetInstanceable(False)"
        )
    checked = {_checked_name(name): _checked_point(name, point) for name, point in points.items()}
    if replace:
        for name in get_keypoints(prim).keys() - checked.keys():
            remove_value(prim, f"{NAMESPACE}:{name}")
    for name, point in checked.items():
        prim.CreateAttribute(f"{NAMESPACE}:{name}", Sdf.ValueTypeNames.Point3d, custom=True).Set(point)


def has_keypoints(prim: Usd.Prim) -> bool:
    """Return whether a prim has keypoints."""
    return bool(prim.GetAuthoredPropertiesInNamespace(NAMESPACE))


def keypoints_vary(prim: Usd.Prim) -> bool:
    """Return whether keypoints of a prim may have another value at another time."""
    found = prim.GetAuthoredPropertiesInNamespace(NAMESPACE)
    return any(isinstance(each, Usd.Attribute) and each.ValueMightBeTimeVarying() for each in found)


def _checked_name(name: str) -> str:
    if not isinstance(name, str) or not Sdf.Path.IsValidIdentifier(name):
        raise ValueError(f"{name!r} cannot name a keypoint: use letters, digits and _, such as 'left_eye'")
    return name


def _checked_point(name: str, point: Sequence[float]) -> Gf.Vec3d:
    try:
        x, y, z = (float(each) for each in point)
    except (TypeError, ValueError):
        raise ValueError(f"keypoint {name!r} is {point!r}; expected three numbers") from None
    return Gf.Vec3d(x, y, z)
