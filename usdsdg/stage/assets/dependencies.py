"""What the layers of an open stage refer to: references that do not open, and those that are found elsewhere."""

from __future__ import annotations

import re
from typing import NamedTuple

from pxr import Ar, Pcp, Sdf, Usd, UsdUtils

from usdsdg.stage.assets import lookup, maps, url
from usdsdg.stage.usd_errors import text_of

_UNRESOLVED = (Pcp.ErrorInvalidAssetPath, Pcp.ErrorInvalidSublayerPath, Pcp.ErrorUnresolvedPrimPath)

# References that are found elsewhere may refer to others again; deeper chains than this are left as they are.
_ROUNDS = 16


class MissingDependency(NamedTuple):
    """A reference, payload or sublayer of an open stage that does not resolve."""

    where: str  # prim path, or identifier of the layer that lists the sublayer
    asset_path: str
    why: str  # USD's message
    layer: str  # identifier of the layer that refers to it


def missing_dependencies(stage: Usd.Stage) -> list[MissingDependency]:
    """Return all references, payloads and sublayers in use that USD could not open, in composition order."""
    found = {}
    for error in stage.GetCompositionErrors():
        prim = stage.GetPrimAtPath(error.rootSite.path)
        if isinstance(error, _UNRESOLVED) and prim and prim.IsActive():
            found[_parsed(error, " ".join(text_of(error).split()))] = None
    return list(found)


def cycles(stage: Usd.Stage) -> list[str]:
    """Return a message for each circle of references, payloads or sublayers, of which USD leaves out an arc."""
    found: dict[frozenset[str], str] = {}
    for error in stage.GetCompositionErrors():
        if isinstance(error, Pcp.ErrorSublayerCycle):
            layers = list(dict.fromkeys(re.findall(r"@([^@]+)@", text_of(error))))
            message = f"{' and '.join(layers)} are sublayers of each other, so USD leaves one out. Remove one of them."
            found.setdefault(frozenset(layers), message)
        elif isinstance(error, Pcp.ErrorArcCycle):
            sites = re.findall(r"@([^@]*)@(?:,@[^@]*@)?<([^>]*)>", text_of(error))
            in_files = len({layer for layer, _ in sites}) > 1
            chain = [f"{layer}<{path}>" if in_files else path for layer, path in sites]
            message = (
                f"{error.rootSite.path}: what it refers to comes back to itself ({' -> '.join(chain)}), so USD leaves "
                "out the last of these arcs. Remove one of them."
            )
            found.setdefault(frozenset(chain), message)
    return list(found.values())


def redirect(stage: Usd.Stage) -> None:
    """Point what the layers of a stage refer to on other machines, or as Windows does, to the files on this one.

    Layers are edited in memory; no file changes.
    """
    seen: set[str] = set()
    for _ in range(_ROUNDS):
        wanted = {each.layer for each in missing_dependencies(stage) if _is_unopened(each.asset_path)} - seen
        if not wanted:
            return
        seen |= wanted
        for identifier in wanted:
            if layer := Sdf.Layer.Find(identifier):
                redirect_layer(layer)


def redirect_layer(layer: Sdf.Layer) -> None:
    """Point the asset paths of one layer that USD cannot open here to files on this machine, where there are any."""
    UsdUtils.ModifyAssetPaths(layer, lambda path: _found(path) if _is_unopened(path) else path)


def is_elsewhere(path: str) -> bool:
    """Whether USD itself cannot open an asset path, while a map or the assets root may have it."""
    text = url.normalized(path)
    if not text or Ar.IsPackageRelativePath(text):
        return False
    return url.is_remote(text) or any(each.rest_of(text) is not None for each in maps.get_maps())


def _is_unopened(path: str) -> bool:
    """Whether USD itself cannot open an asset path on this machine, and another path may stand for it."""
    return is_elsewhere(path) or url.with_slashes(path) != path


def _found(path: str) -> str:
    return lookup.locate_or_none(path) or (path if url.is_remote(path) else url.with_slashes(path))


def _parsed(error: Pcp.ErrorBase, why: str) -> MissingDependency:
    """Parse a composition error, whose paths pxr gives as text only: ... @asset@<prim> ... @layer@."""
    mentioned = re.findall(r"@([^@]+)@(?:<([^>]*)>)?", why)
    asset_path, prim = mentioned[0]
    layer = mentioned[-1][0]
    where = layer if isinstance(error, Pcp.ErrorInvalidSublayerPath) else str(error.rootSite.path)
    return MissingDependency(where, f"{asset_path}<{prim}>" if prim else asset_path, why, layer)
