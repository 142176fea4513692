"""Instances of assets that are sampled again at every execution: `rep.randomizer.instantiate`."""

from dataclasses import replace
from typing import Any

from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from usdsdg import modify
from usdsdg.distribution import Choice, Distribution, choice, draw, one_of, options_of
from usdsdg.errors import ArgumentError, AssetError, BadPrim, counted
from usdsdg.graph.actions import action
from usdsdg.graph.evaluate import graph
from usdsdg.graph.label_sources import LabelSources, brings_labels
from usdsdg.graph.node import Node, ReplicatorItem, prim_paths
from usdsdg.randomizer.population_size import checked_size, drawn_size, largest_size
from usdsdg.session.stage_context import current_stage
from usdsdg.stage import assets, paths
from usdsdg.stage.geometry.instancers import POPULATION, SAMPLED_ASSETS
from usdsdg.stage.scopes import define_scope

MODES = ("scene_instance", "point_instance", "reference")
CACHE = f"{SAMPLED_ASSETS}/Cache"


def instantiate(
    paths: Any, size: Any, weights: Any = None, mode: str = "scene_instance", with_replacements: bool = True,
    seed: int | None = None, name: str | None = None, use_cache: bool = True, semantics: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Create `size` objects, each of which references an asset that is sampled from `paths` at every execution.

    The item's prims are Xforms under `/Replicator/SampledAssets`, which can be posed or labeled like any other; they
    reference their first sample immediately. With mode "point_instance" the item is one PointInstancer: `modify.pose`
    (position, rotation, scale), `rotation`, `scatter_2d` and `scatter_3d` apply to each of its instances, as to those
    of any PointInstancer, and `materials` to each prototype; its labels are those of each instance.

    Prims of the stage that are sampled are hidden, but for mode "point_instance"; their instances are visible also
    where they are not.

    Args:
        paths: USD files (paths or URLs), prims of the stage, an item, or a distribution over these.
        size: how many objects: a whole number, or a distribution of which each execution draws one value, a choice or
            sequence of whole numbers or a uniform between two numbers, which rounds down. The item then has as many
            prims as are shown at most, of which the rest is inactive.
        weights: relative probabilities of the paths, by default equal.
        mode: "scene_instance": instances that share their prototype's geometry and whose descendants cannot be
            edited; "reference": references that can be edited; "point_instance": one PointInstancer.
        with_replacements: whether the same asset may be drawn more than once in an execution.
        seed: replaces the global seed.
        use_cache: keep every asset in memory, under `/Replicator/SampledAssets/Cache`, so that switching opens no
            file. Without it files are referenced when sampled. Prototypes of point instances are always kept.
        semantics: labels of each object; default for mesh files their names as class.

    Raises:
        ArgumentError: an unknown mode, no paths, a size that is none, or `seed` and `weights` beside a distribution.
        AssetNotFound: a path is neither a prim nor a file. AssetError: a file cannot be opened.
    """
    if mode not in MODES:
        raise ArgumentError(f"randomizer.instantiate: mode={mode!r}; known: {', '.join(MODES)}")
    drawn = _choice(paths, weights, with_replacements, seed)
    size = checked_size(size, seed)
    count = largest_size(size)
    if not with_replacements and isinstance(drawn, Choice) and count > len(drawn.node.inputs["choices"]):
        raise ArgumentError(
            f"randomizer.instantiate: size={count} without replacements, but only "
            f"{counted(len(drawn.node.inputs['choices']), 'path')}"
        )
    root = _new_root(name)
    slots = [root] if mode == "point_instance" else [_slot(root) for _ in range(count)]
    inputs = dict(attribute="prims", paths=drawn, mode=mode, size=size, useCache=bool(use_cache))
    if semantics is None:
        inputs["labelMeshes"] = True
    node = Node(kind="OgnInstantiate", inputs=inputs, prims=tuple(slots), name=name)
    item = ReplicatorItem(graph().add(node))
    _instantiate(node, 0)
    if semantics is not None:
        modify.semantics(semantics, input_prims=item)
    return item


def _choice(given: Any, weights: Any, with_replacements: bool, seed: int | None) -> Distribution:
    if isinstance(given, Distribution):
        if weights is not None:
            raise ArgumentError("randomizer.instantiate: give weights to the distribution, not beside it")
        return one_of(given, seed)
    options = list(prim_paths(given))
    if not options:
        raise ArgumentError("randomizer.instantiate: paths is empty")
    for option in options:
        _source(option, labeled=False)
    return one_of(choice(options, weights=weights, with_replacements=with_replacements), seed)


def _source(path: str, *, labeled: bool) -> tuple[str, bool]:
    """Resolve a path to a prim path or a file; return it and whether it is a prim.

    labeled: a mesh file has its name as its class.
    """
    if Sdf.Path.IsValidPathString(path) and Sdf.Path(path).IsAbsolutePath() and current_stage().GetPrimAtPath(path):
        return path, True
    return assets.resolve_object(path, labeled=labeled), False


def _new_root(name: str | None) -> str:
    stage = current_stage()
    define_scope(stage, SAMPLED_ASSETS)
    path = paths.next_free_path(stage, f"{SAMPLED_ASSETS}/{paths.valid_name(name) if name else 'Population'}")
    stage.DefinePrim(path, "Xform")
    return path


def _slot(root: str) -> str:
    stage = current_stage()
    prim = stage.DefinePrim(paths.next_free_path(stage, f"{root}/Ref_Xform"), "Xform")
    prim.CreateAttribute("replicatorXform", Sdf.ValueTypeNames.Bool, custom=True).Set(True)
    return str(prim.GetPath())


@action("OgnInstantiate")
def _instantiate(node: Node, execution: int) -> None:
    if node.inputs["mode"] == "point_instance":
        _fill_instancer(node, execution)
        return
    shared = node.inputs["mode"] == "scene_instance"
    shown: dict[str, str] = node.state
    count = _activate(node, execution)
    for slot, chosen in zip(node.prims[:count], draw(node.inputs["paths"], node, execution, "paths")):
        path = prim_paths(chosen)[0]
        if shown.get(slot) != path:
            _show(slot, _asset(node, path), shared, node.inputs["useCache"])
            shown[slot] = path


def _activate(node: Node, execution: int) -> int:
    """Activate as many objects as an execution shows, and return their number.

    The others are inactive rather than invisible, as bodies that are invisible would still be hit.
    """
    if not node.prims:
        return 0
    stage, root = current_stage(), str(Sdf.Path(node.prims[0]).GetParentPath())
    count = drawn_size(node, root, execution)
    for index, slot in enumerate(node.prims):
        prim = stage.GetPrimAtPath(slot)
        if prim.IsActive() != (index < count):
            prim.SetActive(index < count)
    return count


@brings_labels("OgnInstantiate")
def _assets_to_draw(node: Node, sources: LabelSources) -> None:
    paths = [path for each in options_of(node.inputs["paths"]) for path in prim_paths(each)]
    for path in dict.fromkeys(paths):
        source, is_prim = _asset(node, path)
        stage = current_stage() if is_prim else Usd.Stage.Open(source)
        for slot in node.prims:
            sources.add_content(slot, stage, source if is_prim else None)


def _asset(node: Node, path: str) -> tuple[str, bool]:
    """Return what a path of the node is, a prim path or a file, and whether it is a prim."""
    return _source(path, labeled=bool(node.inputs.get("labelMeshes")))


def _show(slot: str, asset: tuple[str, bool], shared: bool, use_cache: bool) -> None:
    """Set the slot's child to a reference to the asset; the child has no other opinions that could remain."""
    stage = current_stage()
    source, is_prim = asset
    if use_cache and not is_prim:
        source, is_prim = _cached(source), True
    if is_prim and Sdf.Path(slot).HasPrefix(source):
        raise BadPrim(
            f"randomizer.instantiate: {source} contains the instances themselves and cannot be one of their assets"
        )
    child = stage.GetPrimAtPath(f"{slot}/Ref") or stage.DefinePrim(f"{slot}/Ref")
    with Sdf.ChangeBlock():
        reference = Sdf.Reference("", source) if is_prim else Sdf.Reference(source)
        child.GetReferences().SetReferences([reference])
        child.SetInstanceable(shared)
        # A cached prim may be inactive; a reference to it must not be.
        child.SetActive(True)
    if asset[1]:  # a prim of the stage, not of the cache
        _set_visibility(stage.GetPrimAtPath(source), UsdGeom.Tokens.invisible)
        _set_visibility(child, UsdGeom.Tokens.inherited)


def _set_visibility(prim: Usd.Prim, visibility: str) -> None:
    attribute = UsdGeom.Imageable(prim).GetVisibilityAttr()
    if attribute and attribute.Get() != visibility:
        UsdGeom.Imageable(prim).CreateVisibilityAttr(visibility)


def _cached(file: str) -> str:
    """Return the path of the cache prim that references a file; it is created at first use and never rendered."""
    stage = current_stage()
    cache = stage.GetPrimAtPath(CACHE)
    if not cache:
        # A class prim is composed and can be referenced, but is not rendered.
        cache = stage.CreateClassPrim(CACHE)
    for prim in cache.GetAllChildren():
        if prim.GetCustomDataByKey("usdsdg:file") == file:
            return str(prim.GetPath())
    stem = paths.valid_name(file.rsplit("/", 1)[-1].split(".")[0])
    prim = stage.DefinePrim(paths.next_free_path(stage, f"{CACHE}/{stem}"))
    if not prim.GetReferences().AddReference(file):
        raise AssetError(f"randomizer.instantiate: {file} cannot be referenced")
    prim.SetCustomDataByKey("usdsdg:file", file)
    return str(prim.GetPath())


def _fill_instancer(node: Node, execution: int) -> None:
    stage, root = current_stage(), node.prims[0]
    size = drawn_size(node, root, execution)
    instancer = UsdGeom.PointInstancer.Define(stage, root)
    instancer.GetPrim().SetCustomDataByKey(POPULATION, True)
    # One sample per instance, as for prims.
    keys = replace(node, prims=tuple(f"{root}[{index}]" for index in range(size)))
    chosen = [prim_paths(each)[0] for each in draw(node.inputs["paths"], keys, execution, "paths")]
    known: dict[str, int] = node.state
    for path in chosen:
        if path not in known:
            known[path] = _prototype(instancer, path, _asset(node, path))
    instancer.CreateProtoIndicesAttr(Vt.IntArray([known[path] for path in chosen]))
    if len(instancer.GetPositionsAttr().Get() or ()) != size:
        instancer.CreatePositionsAttr(Vt.Vec3fArray(size, Gf.Vec3f(0)))
        instancer.CreateOrientationsAttr(Vt.QuathArray(size, Gf.Quath(1)))
        instancer.CreateScalesAttr(Vt.Vec3fArray(size, Gf.Vec3f(1)))


def _prototype(instancer: UsdGeom.PointInstancer, path: str, asset: tuple[str, bool]) -> int:
    """Return the index of an asset among the prototypes; it is added if it is not there yet."""
    stage, (source, is_prim) = instancer.GetPrim().GetStage(), asset
    relation = instancer.CreatePrototypesRel()
    targets = relation.GetTargets()
    for index, target in enumerate(targets):
        if stage.GetPrimAtPath(target).GetCustomDataByKey("usdsdg:path") == path:
            return index
    prim = stage.DefinePrim(paths.next_free_path(stage, f"{instancer.GetPath()}/Prototype"))
    prim.GetReferences().SetReferences([Sdf.Reference("", source) if is_prim else Sdf.Reference(source)])
    prim.SetCustomDataByKey("usdsdg:path", path)
    if is_prim:
        _set_visibility(prim, UsdGeom.Tokens.inherited)
    relation.SetTargets([*targets, prim.GetPath()])
    return len(targets)
