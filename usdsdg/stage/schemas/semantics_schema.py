"""The label schema of Replicator before 1.12, importable in place of `pxr.Semantics`.

One instance holds one (type, label) pair: `SemanticsAPI:Semantics` with
`semantic:Semantics:params:semanticType` and `...:semanticData`.
"""

from usdsdg.stage.schemas import RESOURCES, register
from usdsdg.stage.schemas.codeless import make_classes

register()

SemanticsAPI = make_classes(RESOURCES / "semantics", __name__)["SemanticsAPI"]
SemanticsAPI.IsSemanticsAPIPath = SemanticsAPI._is_path

__all__ = ["SemanticsAPI"]
