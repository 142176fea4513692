"""The behavior that randomizes the textures of gprims."""

from __future__ import annotations

import logging
import string
from typing import ClassVar

from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

from usdsdg.compat.isaacsim.replicator.behavior.base_behavior import INTERVAL, Variable, variable
from usdsdg.compat.isaacsim.replicator.behavior.global_variables import SCOPE_NAME
from usdsdg.compat.isaacsim.replicator.behavior.prims_behavior import INCLUDE_CHILDREN, SEED, RandomBehavior
from usdsdg.compat.isaacsim.replicator.behavior.utils.asset_lists import asset_files
from usdsdg.compat.isaacsim.replicator.behavior.utils.behavior_utils import remove_empty_scopes
from usdsdg.compat.isaacsim.replicator.behavior.utils.scene_utils import create_mdl_material
from usdsdg.stage.paths import next_free_path

_T = Sdf.ValueTypeNames
_PATTERNS = "/Isaac/Materials/Textures/Patterns"
_log = logging.getLogger("usdsdg.script")


class TextureRandomizer(RandomBehavior):
    """Gives each gprim an OmniPBR material of its own and draws its texture, projection, scale and rotation."""

    BEHAVIOR_NS: ClassVar[str] = "textureRandomizer"
    VARIABLES_TO_EXPOSE: ClassVar[list[Variable]] = [
        INCLUDE_CHILDREN,
        INTERVAL,
        variable("textures:assets", _T.AssetArray, [], "Textures to draw from."),
        variable(
            "textures:csv",
            _T.String,
            f"{_PATTERNS}/nv_bamboo_desktop.jpg,{_PATTERNS}/nv_brick_grey.jpg",
            "More textures: URLs, or paths under the assets root, separated by commas.",
        ),
        variable("projectUvwProbability", _T.Float, 0.9, "Probability that a texture is projected."),
        variable("textureScaleRange", _T.Float2, Gf.Vec2f(0.1, 1.0), "Smallest and largest scale of a texture."),
        variable("textureRotateRange", _T.Float2, Gf.Vec2f(0.0, 45.0), "Smallest and largest rotation [degrees]."),
        SEED,
    ]

    def on_init(self) -> None:
        self._materials: dict[Usd.Prim, UsdShade.Material] = {}
        self._before: dict[Usd.Prim, UsdShade.Material] = {}
        super().on_init()

    def _applies_to(self, prim: Usd.Prim) -> bool:
        return prim.IsA(UsdGeom.Gprim)

    def _read_variables(self) -> None:
        self._projected = float(self._get_exposed_variable("projectUvwProbability"))
        self._scale = self._get_exposed_variable("textureScaleRange")
        self._rotate = self._get_exposed_variable("textureRotateRange")

    def _begin(self) -> None:
        self._textures = asset_files(
            self._get_exposed_variable("textures:assets"), self._get_exposed_variable("textures:csv")
        )
        self._looks = next_free_path(self.stage, f"{SCOPE_NAME}/{self.BEHAVIOR_NS}/Looks", False)
        super()._begin()

    def _remember(self, prim: Usd.Prim) -> None:
        """Keep the bound material, and bind one of its own."""
        self._before[prim] = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
        suffix = "".join(self._rng.choice(list(string.ascii_letters + string.digits), size=4))
        path = next_free_path(self.stage, f"{self._looks}/OmniPBR_{suffix}", False)
        self._materials[prim] = create_mdl_material("OmniPBR.mdl", "OmniPBR", path)
        _bind(prim, self._materials[prim])

    def _restore(self, prim: Usd.Prim) -> None:
        if prim not in self._before:
            return
        if before := self._before.pop(prim):
            _bind(prim, before)
        else:
            UsdShade.MaterialBindingAPI(prim).UnbindAllBindings()

    def _reset(self) -> None:
        super()._reset()
        for material in self._materials.values():
            self.stage.RemovePrim(material.GetPath())
        self._materials.clear()
        remove_empty_scopes(self.stage.GetPrimAtPath(SCOPE_NAME), self.stage)

    def _apply_behavior(self) -> None:
        if not self._textures:
            _log.warning("[%s] TextureRandomizer has no textures", self.prim_path)
            return
        for material in self._materials.values():
            shader = UsdShade.Shader(material.GetPrim().GetChild("Shader"))
            shader.GetInput("diffuse_texture").Set(Sdf.AssetPath(str(self._rng.choice(self._textures))))
            projected = self._rng.choice([True, False], p=[self._projected, 1.0 - self._projected])
            shader.GetInput("project_uvw").Set(bool(projected))
            scale = self._rng.uniform(*self._scale)
            shader.GetInput("texture_scale").Set(Gf.Vec2f(scale, scale))
            shader.GetInput("texture_rotate").Set(self._rng.uniform(*self._rotate))


def _bind(prim: Usd.Prim, material: UsdShade.Material) -> None:
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material, UsdShade.Tokens.strongerThanDescendants)
