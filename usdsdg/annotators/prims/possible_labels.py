"""The sets of labels that prims can show at some frame, as stage and graph tell before any frame is drawn."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import islice, product

from pxr import Sdf, Usd, UsdGeom

from usdsdg.annotators.ownership import LabeledStage, Labels, lower, output_labels
from usdsdg.graph.label_sources import Edit, LabelSources
from usdsdg.stage.semantics.label_filter import LabelFilter
from usdsdg.stage.semantics.labels import get_labels, merged

# Some nodes add labels to labels: what one prim can come to, and what one gprim can inherit, stays a list.
MAX_STATES, MAX_STACKS = 64, 4096

Stack = Sequence[Labels]  # own labels of a gprim and its ancestors, outermost first


def possible_outputs(
    labeled: LabeledStage, sources: LabelSources, label_filter: LabelFilter | None
) -> list[dict[str, str]]:
    """Return the sets of labels {type: "label[,label]"} that nodes can bring about, beside those that are there."""
    found: dict[tuple[tuple[str, str], ...], dict[str, str]] = {}
    for stack, of_material in {**_edited(labeled, sources), **_brought(labeled, sources)}.values():
        output = _output(stack, of_material, label_filter)
        if output:
            found.setdefault(tuple(sorted(output.items())), output)
    return list(found.values())


_Stacks = dict[str, tuple[Stack, Labels]]  # by what they hold, so that equal ones of many prims count once


def _edited(labeled: LabeledStage, sources: LabelSources) -> _Stacks:
    """Return the stacks of gprims that are there, with the labels and materials that nodes can give them."""
    found: _Stacks = {}
    for gprim in labeled.every_gprim():
        chain = labeled.ancestry(gprim)
        paths = [path for path, _ in chain]
        if any(path in sources.edits or path in sources.materials for path in paths):
            states = [_states(own, sources.edits.get(path, ())) for path, own in chain]
            for of_material in _materials(labeled, sources, paths):
                _note(found, product(*states), of_material)
    return found


def _brought(labeled: LabeledStage, sources: LabelSources) -> _Stacks:
    """Return the stacks of gprims that nodes can bring below prims."""
    found: _Stacks = {}
    for parent, root in sources.contents:
        chain = labeled.ancestry(str(parent))
        above = [_states(own, sources.edits.get(path, ())) for path, own in chain]
        choices = _materials(labeled, sources, [path for path, _ in chain])
        for inside in _stacks_below(root):
            for of_material in choices:
                _note(found, (
                    (*outer, *inside) for outer in islice(product(*above), MAX_STACKS)
                ), of_material)  # fmt: skip
    return found


def _note(found: _Stacks, stacks: Iterable[Stack], of_material: Labels) -> None:
    for stack in islice(stacks, MAX_STACKS):
        shown = [labels for labels in stack if labels]
        found.setdefault(repr((shown, of_material)), (shown, of_material))


def _states(own: Labels, edits: Sequence[Edit]) -> list[Labels]:
    """Return what a prim's own labels can become by any of the edits in any order."""
    found: dict[str, Labels] = {repr(own): own}
    pending = [own]
    while pending and len(found) < MAX_STATES:
        state = pending.pop(0)
        for edit in edits:
            after = lower(edit({kind: list(values) for kind, values in state.items()}))
            if repr(after) not in found:
                found[repr(after)] = after
                pending.append(after)
    return list(found.values())


def _materials(labeled: LabeledStage, sources: LabelSources, paths: Sequence[Sdf.Path]) -> list[Labels]:
    """Return the labels of the materials that nodes can bind to one of the prims; none where they bind none."""
    bound = [material for path in paths for material in sources.materials.get(path, ())]
    return [{}, *(labeled.own_labels(material) for material in dict.fromkeys(bound))]


def _stacks_below(root: Usd.Prim) -> Iterator[Stack]:
    """Yield the labels of each gprim at or below a prim of any stage, from the root inward."""
    inside = Usd.PrimRange(root, Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate))
    own = {prim.GetPath(): lower(get_labels(prim)) for prim in inside}
    seen = set()
    for prim in Usd.PrimRange(root, Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)):
        if prim.IsA(UsdGeom.Gprim):
            stack = [own[path] for path in prim.GetPath().GetPrefixes() if own.get(path)]
            if repr(stack) not in seen:
                seen.add(repr(stack))
                yield stack


def _output(stack: Stack, of_material: Labels, label_filter: LabelFilter | None) -> dict[str, str]:
    """Return the labels that annotators would output: those of the innermost prim that passes, and what it inherits."""
    own = [*stack[:-1], merged([stack[-1], of_material])] if stack else [of_material]
    passing = [index for index, labels in enumerate(own) if label_filter is None or label_filter.select(labels)]
    if not passing:
        return {}
    return output_labels(merged([*own[: passing[-1] + 1], of_material]), label_filter)
