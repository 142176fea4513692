"""What the nodes of the graph can do to labels: the labels that a prim may have at some later frame."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from pxr import Sdf, Usd

from usdsdg.session.session import current

if TYPE_CHECKING:
    from usdsdg.graph.node import Node

Labels = dict[str, list[str]]  # by type
Edit = Callable[[Labels], Labels]


@dataclass
class LabelSources:
    """Changes of labels that nodes can make, by the path of the prim that they act on."""

    edits: dict[Sdf.Path, list[Edit]] = field(default_factory=dict)  # of the prim's own labels
    contents: list[tuple[Sdf.Path, Usd.Prim]] = field(default_factory=list)  # a prim that can come below a path
    materials: dict[Sdf.Path, list[Sdf.Path]] = field(default_factory=dict)  # that can be bound to the prim
    stages: list[Usd.Stage] = field(default_factory=list)  # those of `contents`, which must stay open

    def __bool__(self) -> bool:
        return bool(self.edits or self.contents or self.materials)

    def add_edit(self, path: str, edit: Edit) -> None:
        """Note that the prim's own labels can become `edit` of what they are."""
        self.edits.setdefault(Sdf.Path(path), []).append(edit)

    def add_content(self, parent: str | Sdf.Path, stage: Usd.Stage, path: str | Sdf.Path | None = None) -> None:
        """Note that what is at and below a prim of any stage (None: its default prim) can come below `parent`."""
        if prim := stage.GetDefaultPrim() if path is None else stage.GetPrimAtPath(path):
            self.contents.append((Sdf.Path(parent), prim))
            self.stages.append(stage)

    def add_materials(self, path: str, materials: Iterable[str]) -> None:
        """Note that these materials can be bound to the prim."""
        self.materials.setdefault(Sdf.Path(path), []).extend(map(Sdf.Path, materials))


Finder = Callable[["Node", LabelSources], None]

_FINDERS: dict[str, Finder] = {}


def brings_labels(kind: str) -> Callable[[Finder], Finder]:
    """Register a function that notes which labels nodes of type `kind` can bring, without executing them."""

    def register(finder: Finder) -> Finder:
        _FINDERS[kind] = finder
        return finder

    return register


def label_sources() -> LabelSources:
    """Return what the nodes of the current graph can do to labels, under triggers or waiting for their first run."""
    sources, graph = LabelSources(), current().graph
    nodes: Sequence[Node] = [*graph.impulses, *(node for trigger in graph.triggers for node in trigger.nodes)]
    for node in nodes:
        if finder := _FINDERS.get(node.kind):
            finder(node, sources)
    return sources
