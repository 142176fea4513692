"""Materials from MDL files."""

import os
from typing import Any, TypeGuard

from pxr import Tf, Usd, UsdShade

from usdsdg.session.stage_context import current_stage
from usdsdg.stage import assets, materials, paths
from usdsdg.stage.scopes import LOOKS, define_scope


def is_mdl(value: Any) -> TypeGuard[str]:
    """Return whether a value is the name of an MDL file."""
    return isinstance(value, str) and value.lower().endswith(".mdl")


def mdl_material(mdl: str) -> Usd.Prim:
    """Return a material below `/Replicator/Looks` of an MDL file, defined at the first use.

    Args:
        mdl: a file, a URL below the assets root, or the bare name of a module of Omniverse such as "OmniPBR.mdl". The
            material is the one that has the name of the file.

    Raises:
        AssetNotFound: there is no such file.
    """
    stage = current_stage()
    file = mdl if os.path.basename(mdl) == mdl and not os.path.exists(mdl) else assets.resolve(mdl)
    name = Tf.MakeValidIdentifier(os.path.basename(file.replace("\\", "/")).rsplit(".", 1)[0])
    usual = stage.GetPrimAtPath(f"{LOOKS}/{name}")
    if usual and usual.IsA(UsdShade.Material) and materials.mdl_file(usual) == file:
        return usual
    define_scope(stage, LOOKS)
    return materials.define_mdl(stage, paths.next_free_path(stage, f"{LOOKS}/{name}"), file).GetPrim()
