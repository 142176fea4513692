"""Owners of gprims: the nearest labeled ancestor (or the gprim itself) that passes a label filter."""

import itertools
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import NamedTuple

from pxr import Sdf, Usd, UsdGeom, UsdShade

from usdsdg.annotators.point_instances import Steps, find_steps, first_points, prim_path, undefined_prototypes
from usdsdg.annotators.prims.subset_setting import subsets_are_told_apart
from usdsdg.arguments.registry import near_misses
from usdsdg.errors import warn_once
from usdsdg.stage.changes import is_below
from usdsdg.stage.geometry.instancers import POPULATION
from usdsdg.stage.geometry.point_names import Prototypes
from usdsdg.stage.geometry.triangles import range_below
from usdsdg.stage.prims.prim_types import PrimTypes
from usdsdg.stage.semantics.label_filter import LabelFilter
from usdsdg.stage.semantics.labels import (
    get_labels,
    is_labeled,
    labels_without_schema,
    merged,
    schemas_without_label,
    vary_over_time,
)

Labels = Mapping[str, Sequence[str]]

# Number of labels that a warning lists.
LISTED = 8


class Owner(NamedTuple):
    """A labeled prim; inside a point instancer's prototype, one of its instances."""

    path: Sdf.Path
    steps: Steps = ()

    @property
    def name(self) -> str:
        """The prim path that annotators report."""
        return str(self.path) + "".join(step.name for step in self.steps)


# The labeled ancestors of a gprim, and itself, with their own labels, nearest first.
Chain = Sequence[tuple[Owner, Labels]]


class LabeledStage:
    """The labels of a stage at one time, read once per prim."""

    def __init__(self, stage: Usd.Stage) -> None:
        self._stage = stage
        self._time = Usd.TimeCode.Default()
        self._own: dict[Sdf.Path, Labels] = {}
        self._varying: set[Sdf.Path] = set()  # prims whose labels have time samples
        self._materials_have_labels = False
        self._unread = {Sdf.Path.absoluteRootPath}  # subtrees in which materials were not looked at
        # Chains of gprims that were asked for, and labels of owners: most edits leave most of them as they are.
        self._chains: dict[str, tuple[Steps, list[tuple[Owner, Labels]]]] = {}
        self._inherited: dict[Owner, Labels] = {}
        self._checked: set[Sdf.Path] = set()  # prims whose labels without a schema were named

    def invalidate(self, roots: Collection[Sdf.Path] = (Sdf.Path.absoluteRootPath,)) -> None:
        """Read the labels at and below `roots` again when they are next needed."""
        self._unread |= {Sdf.Path.absoluteRootPath} if self._materials_have_labels else {*roots}
        if self._materials_have_labels:
            self.forget_chains()
        self._materials_have_labels = False
        # Those of point instances depend on instancers elsewhere.
        self._chains = {
            gprim: each for gprim, each in self._chains.items() if not each[0] and not is_below(prim_path(gprim), roots)
        }
        self._inherited = {
            owner: each
            for owner, each in self._inherited.items()
            if not owner.steps and not is_below(owner.path, roots)
        }
        self._own = {path: own for path, own in self._own.items() if not is_below(path, roots)}
        self._varying = {path for path in self._varying if not is_below(path, roots)}

    def forget_chains(self) -> None:
        """Find the labeled ancestors of all gprims again, by labels that are known."""
        self._chains.clear()
        self._inherited.clear()

    @property
    def has_labeled_materials(self) -> bool:
        """Whether labels of materials were read, so that they depend on what prims bind."""
        return self._materials_have_labels

    def set_time(self, time: Usd.TimeCode) -> bool:
        """Read labels at this time from now on; return whether some may differ."""
        self._time = time
        for path in self._varying:
            self._own.pop(path, None)
        if self._varying:
            self.forget_chains()
        return bool(self._varying)

    def chains(self, gprims: Sequence[str]) -> list[tuple[Steps, list[tuple[Owner, Labels]]]]:
        """Return, for each gprim, its instance path and its labeled ancestors with their own labels, nearest first.

        Labels of the material that a gprim shows count as those of the prim that binds it.
        """
        self._look_at_materials()
        known = self._chains
        missing = [gprim for gprim in gprims if gprim not in known]
        if missing:
            if len(known) > 2 * len(gprims) + 64:  # of frames that showed others
                known.clear()
                missing = list(gprims)
            known.update(zip(missing, self._find_chains(missing)))
        return [known[gprim] for gprim in gprims]

    def _find_chains(self, gprims: Sequence[str]) -> list[tuple[Steps, list[tuple[Owner, Labels]]]]:
        all_steps, materials = find_steps(self._stage, gprims), self._materials(gprims)
        found = []
        for gprim, steps in zip(gprims, all_steps):
            binder, of_material = materials.get(prim_path(gprim), (None, {}))
            chain = []
            for owner in ancestors(prim_path(gprim), steps):
                own = self._own_labels(owner)
                if owner.path == binder:
                    own = merged([own, of_material])
                if own:
                    chain.append((owner, own))
            found.append((steps, chain))
        return found

    def every_gprim(self, *, numbered: bool = True) -> list[str]:
        """Return the gprims of the stage in its order, visible or not, and GeomSubsets that have labels of their own.

        Those of prototypes are instances of point 0, or with `numbered` False of none.
        """
        prototypes = Prototypes(self._stage)
        everything = itertools.chain(
            Usd.PrimRange.Stage(self._stage, Usd.TraverseInstanceProxies()),
            # Classes and overs are drawn where they are prototypes of point instancers.
            *map(range_below, undefined_prototypes(self._stage, prototypes)),
        )
        kinds = (UsdGeom.Gprim, UsdGeom.Subset) if subsets_are_told_apart() else (UsdGeom.Gprim,)
        paths = [str(prim.GetPath()) for prim in filter(PrimTypes(*kinds).have, everything)]
        return first_points(self._stage, paths, prototypes) if numbered else paths

    def all_labels(self, owner: Owner, gprims: Sequence[str]) -> Labels:
        """Return own and inherited labels by type, outermost first, then those of the materials of the owner's gprims.

        Through a point instancer labels are inherited from what the instancer is in, not from where its prototypes are.
        """
        materials = self._materials(gprims)
        if not materials and owner in self._inherited:
            return self._inherited[owner]
        chain = [self._labels(each.path) for each in ancestors(owner.path, owner.steps)]
        found = merged([*reversed(chain), *(labels for _, labels in materials.values())])
        if not materials:
            self._inherited[owner] = found
        return found

    def ancestry(self, gprim: str) -> list[tuple[Sdf.Path, Labels]]:
        """Return the path and own labels of a prim's ancestors and itself, outermost first."""
        [steps] = find_steps(self._stage, [gprim])
        chain = [(owner.path, self._own_labels(owner)) for owner in ancestors(prim_path(gprim), steps)]
        return chain[::-1]

    def own_labels(self, path: Sdf.Path) -> Labels:
        """Return a prim's own labels; none where there is no prim."""
        return self._labels(path)

    def _own_labels(self, owner: Owner) -> Labels:
        """Return the labels of a prim; on the root of a point instance also those of the population."""
        own = self._labels(owner.path)
        if not owner.steps or owner.path != owner.steps[0].prototype:
            return own
        instancer = owner.steps[0].instancer
        population = self._stage.GetPrimAtPath(instancer).GetCustomDataByKey(POPULATION)
        return merged([self._labels(instancer), own]) if population else own

    def _materials(self, gprims: Sequence[str]) -> dict[Sdf.Path, tuple[Sdf.Path, Labels]]:
        """Return for each gprim with a labeled material the prim that binds it, and the material's labels."""
        self._look_at_materials()
        if not self._materials_have_labels:
            return {}
        prims = [self._stage.GetPrimAtPath(path) for path in dict.fromkeys(map(prim_path, gprims))]
        bound, bindings = UsdShade.MaterialBindingAPI.ComputeBoundMaterials([prim for prim in prims if prim])
        return {
            prim.GetPath(): (binding.GetPrim().GetPath(), labels)
            for prim, material, binding in zip(filter(None, prims), bound, bindings, strict=True)
            if material and (labels := self._labels(material.GetPath()))
        }

    def _look_at_materials(self) -> None:
        """Find out whether materials have labels where that is not known."""
        if not self._unread:
            return
        roots, self._unread = Sdf.Path.RemoveDescendentPaths(list(self._unread)), set()
        materials, all_prims = PrimTypes(UsdShade.Material), Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)
        for root in filter(None, map(self._stage.GetPrimAtPath, roots)):
            if any(map(is_labeled, filter(materials.have, Usd.PrimRange(root, all_prims)))):
                self._materials_have_labels = True
                self.forget_chains()
                return

    def _labels(self, path: Sdf.Path) -> Labels:
        if path not in self._own:
            prim = self._stage.GetPrimAtPath(path)
            self._own[path] = lower(get_labels(prim, self._time)) if prim else {}
            _name_commas(path, self._own[path])
            if prim and path not in self._checked:
                self._checked.add(path)
                _name_unapplied(prim)
            if prim and vary_over_time(prim):
                self._varying.add(path)
        return self._own[path]


def _name_commas(path: Sdf.Path, labels: Labels) -> None:
    """Warn of labels with commas, which files cannot tell from several labels."""
    for label in (label for values in labels.values() for label in values if "," in label):
        warn_once(
            f"{path}: the label {label!r} has a comma, which separates labels in what annotators and files tell, so "
            "that it reads as several. Write it without, or author several labels."
        )


def _name_unapplied(prim: Usd.Prim) -> None:
    """Warn of labels whose schema a prim lacks, and of schemas without a label.

    Once for each schema, since a file has them so on all of its prims.
    """
    for name, schema in labels_without_schema(prim):
        warn_once(
            f"{prim.GetPath()}: {name} is no label, since {schema} is not applied to the prim; others may lack it. "
            f'Add prepend apiSchemas = ["{schema}"] to such prims, or label them with rep.modify.semantics.',
            key=f"labels without {schema}",
        )
    for schema, name in schemas_without_label(prim):
        warn_once(
            f"{prim.GetPath()} has {schema} and no label in it, so that it gives none; others may lack it, too. Set "
            f"{name}, or label the prim with rep.modify.semantics.",
            key=f"{schema} without labels",
        )


def ancestors(path: Sdf.Path, steps: Steps) -> Iterator[Owner]:
    """Yield the prim and its ancestors; the root of a prototype is followed by the instancer that draws it."""
    while not path.IsAbsoluteRootPath():
        yield Owner(path, steps)
        if steps and path == steps[0].prototype:
            path, steps = steps[0].instancer, steps[1:]
        else:
            path = path.GetParentPath()


class Owned(NamedTuple):
    """An owner of gprims, with its labels."""

    owner: Owner
    group: tuple[int, ...]  # indices of its gprims
    labels: Labels  # own and inherited
    output: dict[str, str]  # those that pass, as annotators output them; not empty


def find_owners(
    stage: LabeledStage,
    gprims: Sequence[str],
    chains: Sequence[Chain],
    label_filter: LabelFilter | None,
) -> Iterator[Owned]:
    """Yield the owners of gprims in the order of their first one.

    A prim whose own labels pass, but not together with those that it inherits, is left out with its gprims.
    """
    for owner, group in _group_by_owner(chains, label_filter).items():
        labels = stage.all_labels(owner, [gprims[index] for index in group])
        if output := output_labels(labels, label_filter):
            yield Owned(owner, group, labels, output)


def _group_by_owner(chains: Sequence[Chain], label_filter: LabelFilter | None) -> dict[Owner, tuple[int, ...]]:
    groups: dict[Owner, list[int]] = {}
    for index, chain in enumerate(chains):
        owner = next((owner for owner, own in chain if label_filter is None or label_filter.select(own)), None)
        if owner is not None:
            groups.setdefault(owner, []).append(index)
    return {owner: tuple(group) for owner, group in groups.items()}


def parse_filter(predicate: str | None) -> LabelFilter | None:
    """Parse a label filter; its labels are lower-cased, as those of the stage are."""
    return LabelFilter(re.sub(r":[^,;]*", lambda labels: labels[0].lower(), predicate)) if predicate else None


def warn_of_empty_selection(predicate: str | None, owned: Sequence[Labels]) -> None:
    """Warn that a filter selects none of the labels on the stage, and list those."""
    there = {f"{kind}:{label}" for own in owned for kind, values in own.items() for label in values}
    if not there or not predicate:
        return
    types, values = ({pair.split(":", 1)[part] for pair in there} for part in (0, 1))
    clauses = [clause.split(":", 1) for clause in re.split(r"[;,]", predicate)]
    asked = [(kind.strip(), types) for kind, _ in clauses]
    asked += [(label.strip(), values) for _, labels in clauses for label in re.split(r"[|&!]", labels)]
    near = dict.fromkeys(hit for word, known in asked if word not in known for hit in near_misses(word, known, count=1))
    hint = f"did you mean {' or '.join(near)}? " if near else ""
    some = ", ".join(sorted(there)[:LISTED]) + (", ..." if len(there) > LISTED else "")
    warn_once(f"the semantic filter {predicate!r} selects none of the labels on the stage; {hint}there are: {some}")


def output_labels(labels: Labels, label_filter: LabelFilter | None) -> dict[str, str]:
    """Return the labels that pass in the form of annotator outputs: {type: "label[,label]"}."""
    kept = labels if label_filter is None else label_filter.select(labels)
    return {kind: ",".join(values) for kind, values in kept.items()}


def lower(labels: Labels) -> Labels:
    """Return labels in lower case, as annotators output them; types keep their case."""
    return {kind: tuple(dict.fromkeys(value.lower() for value in values)) for kind, values in labels.items()}
