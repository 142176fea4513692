"""A stage as a tree of prims with types and labels."""

from __future__ import annotations

from pxr import Usd, UsdGeom

from usdsdg.errors import counted
from usdsdg.notebook import html
from usdsdg.stage.semantics.labels import get_labels

# Prims that are listed, in all and below one prim, and depth to which the tree is open.
PRIMS, CHILDREN, OPEN = 400, 40, 2


def stage_html(stage: Usd.Stage) -> str:
    """Return what a notebook shows of a stage."""
    if not stage:
        return html.note("the stage is closed")
    top = [*stage.GetPseudoRoot().GetChildren()]
    meters, up = UsdGeom.GetStageMetersPerUnit(stage), UsdGeom.GetStageUpAxis(stage)
    about = f"{up} up, {meters:g} m per unit, {counted(sum(1 for _ in stage.Traverse()), 'prim')}"
    layer = stage.GetRootLayer()
    name = "stage" if layer.anonymous else layer.GetDisplayName()
    return html.title(name, about) + _Tree().below(top, 0)


def prim_html(prim: Usd.Prim) -> str:
    """Return what a notebook shows of a prim: the tree below it, and its attributes."""
    if not prim:
        return html.note("the prim is not on its stage any more")
    values = [(each.GetName(), each.GetTypeName(), each.Get()) for each in prim.GetAuthoredAttributes()]
    return _Tree().below([prim], 0) + html.details("attributes", html.table(("name", "type", "value"), values))


class _Tree:
    """Lists prims until there are too many."""

    def __init__(self) -> None:
        self._left = PRIMS

    def below(self, prims: list[Usd.Prim], depth: int) -> str:
        listed = prims[: min(CHILDREN, self._left)]
        self._left -= len(listed)
        parts = [self._prim(prim, depth) for prim in listed]
        if len(prims) > len(listed):
            parts.append(html.note(f"and {len(prims) - len(listed)} more"))
        return "".join(parts)

    def _prim(self, prim: Usd.Prim, depth: int) -> str:
        labels = [f"{kind}: {', '.join(names)}" for kind, names in get_labels(prim).items()]
        hidden = ["invisible"] if _is_hidden(prim) else []
        about = "; ".join([prim.GetTypeName() or "typeless", *labels, *hidden])
        children = [*prim.GetFilteredChildren(Usd.TraverseInstanceProxies())]
        line = html.title(prim.GetName(), about)
        if not children:
            return html.indented(line)
        line = line.removeprefix("<div>").removesuffix("</div>")
        return html.indented(html.details(line, self.below(children, depth + 1), is_open=depth < OPEN))


def _is_hidden(prim: Usd.Prim) -> bool:
    imageable = UsdGeom.Imageable(prim)
    return bool(imageable) and imageable.GetVisibilityAttr().Get() == UsdGeom.Tokens.invisible
