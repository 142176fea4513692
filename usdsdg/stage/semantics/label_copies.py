"""The same labels for many prims: written to one of them, and copied from there to the others in one change."""

from collections.abc import Mapping, Sequence

from pxr import Sdf, Usd

from usdsdg.stage.change_tracker import schemas_only
from usdsdg.stage.semantics.label_schemas import PREFIXES
from usdsdg.stage.semantics.labels import add_labels


def label_all(prims: Sequence[Usd.Prim], labels: Mapping[str, Sequence[str]]) -> None:
    """Do what `add_labels` does for each of some prims of one stage, of which those without any labels are many.

    Raises:
        BadPrim, ValueError: as `add_labels`.
    """
    bare = [prim for prim in dict.fromkeys(prims) if _is_bare(prim)]
    target = bare[0].GetStage().GetEditTarget() if bare else Usd.EditTarget()
    if len(bare) > 1 and target.GetMapFunction().isIdentity and not _label_names(target.GetLayer(), bare[0]):
        add_labels(bare[0], labels)
        _copy(target.GetLayer(), bare[0], bare[1:])
        copied = set(bare)
        prims = [prim for prim in prims if prim not in copied]
    for prim in prims:
        add_labels(prim, labels)


def _is_bare(prim: Usd.Prim) -> bool:
    """Whether a prim can be edited and has neither applied schemas nor custom data, which would have to be merged."""
    if not prim or prim.IsInstanceProxy() or prim.IsInPrototype():
        return False
    return not (prim.GetAppliedSchemas() or prim.HasAuthoredMetadata("apiSchemas") or prim.HasAuthoredCustomData())


def _label_names(layer: Sdf.Layer, prim: Usd.Prim) -> list[str]:
    """The names of the layer's properties of a prim that hold labels."""
    spec = layer.GetPrimAtPath(prim.GetPath())
    return [each.name for each in spec.properties if each.name.startswith(PREFIXES)] if spec else []


def _copy(layer: Sdf.Layer, source: Usd.Prim, prims: Sequence[Usd.Prim]) -> None:
    """Copy what labels a prim in a layer to prims that are bare."""
    labeled = source.GetPath()
    paths = [labeled.AppendProperty(name) for name in _label_names(layer, source)]
    keys = ("apiSchemas", "customData")
    spec = layer.GetPrimAtPath(labeled)
    metadata = {key: spec.GetInfo(key) for key in keys if spec.HasInfo(key)}
    with schemas_only(), Sdf.ChangeBlock():
        for prim in prims:
            at = prim.GetPath()
            copy = layer.GetPrimAtPath(at) or Sdf.CreatePrimInLayer(layer, at)
            for path in paths:
                Sdf.CopySpec(layer, path, layer, at.AppendProperty(path.name))
            for key, value in metadata.items():
                copy.SetInfo(key, value)
