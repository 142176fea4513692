"""What annotators need rendered."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from usdsdg.annotators.annotator import Annotator


@dataclass(frozen=True)
class Requirements:
    """What a set of annotators needs rendered in one frame."""

    aovs: frozenset[str] = frozenset()
    amodal_masks: bool = False
    path_tracing: bool = False
    filters: tuple[str | None, ...] = ()
    earlier_captures: int = 0
    poses: bool = False  # of labeled prims, and their bounds


def requirements(annotators: Iterable[Annotator]) -> Requirements:
    """Return the union of what `annotators` need."""
    annotators = list(annotators)
    return Requirements(
        frozenset().union(*(a.aovs for a in annotators)),
        any(a.spec.needs_amodal_masks for a in annotators),
        any(a.spec.needs_path_tracing for a in annotators),
        tuple(dict.fromkeys(a.label_filter for a in annotators)),
        max((a.earlier_captures for a in annotators), default=0),
        any(a.spec.needs_poses for a in annotators),
    )
