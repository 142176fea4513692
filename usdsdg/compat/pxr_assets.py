"""Asset URLs in pxr's own calls: Omniverse's resolver opens them, USD's does not, and none can be written in Python.

The methods that take the URL of a layer are wrapped, so that `prim.GetReferences().AddReference("omniverse://...")`
refers to the file on this machine.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Callable
from typing import Any

from pxr import Sdf, Usd

from usdsdg.stage import assets

# Class -> methods whose first argument is an asset path, a reference or a payload, or a list of these.
WRAPPED = (
    (Usd.References, ("AddReference", "RemoveReference", "SetReferences")),
    (Usd.Payloads, ("AddPayload", "RemovePayload", "SetPayloads")),
)


def install() -> None:
    """Wrap the methods, once."""
    for owner, names in WRAPPED:
        for name in names:
            method = getattr(owner, name)
            if not hasattr(method, "__wrapped__"):
                setattr(owner, name, _resolving(method))
    if not hasattr(Usd.Stage.Open, "__wrapped__"):
        Usd.Stage.Open = staticmethod(_opening(Usd.Stage.Open))


def _resolving(method: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(method, assigned=("__name__", "__doc__"), updated=())
    def call(owner: Any, *arguments: Any, **options: Any) -> Any:
        given = [_resolved(each) if index == 0 else each for index, each in enumerate(arguments)]
        if "assetPath" in options:
            options["assetPath"] = _file(options["assetPath"])
        return method(owner, *given, **options)

    return call


def _opening(method: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(method, assigned=("__name__", "__doc__"), updated=())
    def call(*arguments: Any, **options: Any) -> Any:
        if arguments and isinstance(arguments[0], str):
            arguments = (_here(arguments[0]), *arguments[1:])
        return method(*arguments, **options)

    return call


def _resolved(value: Any) -> Any:
    """Return an argument with the files on this machine in place of asset URLs; others as they are."""
    if isinstance(value, str):
        return _file(value)
    if isinstance(value, Sdf.Reference):
        return Sdf.Reference(_file(value.assetPath), value.primPath, value.layerOffset, value.customData)
    if isinstance(value, Sdf.Payload):
        return Sdf.Payload(_file(value.assetPath), value.primPath, value.layerOffset)
    if isinstance(value, list):
        return [_resolved(each) for each in value]
    return value


def _file(asset: str) -> str:
    """Return the file of an asset URL, or what takes its place where it is missing; of a mesh the USD file."""
    if assets.is_mesh(asset):
        return assets.resolve(asset)
    if _is_sought(asset) and assets.get_on_missing() is not assets.OnMissing.RAISE:
        return assets.resolve(asset)
    return _here(asset)


def _here(asset: str) -> str:
    """Return the file of an asset URL, or the URL itself, which USD then reports as missing."""
    if assets.is_mesh(asset) and os.path.isfile(asset):
        return assets.resolve(asset)
    return (assets.locate_or_none(asset) if _is_sought(asset) else None) or asset


def _is_sought(asset: str) -> bool:
    """Whether USD cannot open an asset path: it names another machine, or a file that is not there.

    Relative paths belong to the layer that holds them.
    """
    if not asset or Sdf.Layer.IsAnonymousLayerIdentifier(asset) or ":SDF_FORMAT_ARGS:" in asset:
        return False
    return assets.is_elsewhere(asset) or (os.path.isabs(asset) and not assets.exists(asset))
