"""Augmentations as users hold and name them: `rep.annotators.Augmentation`, `get_augmentation` and their like."""

from typing import Any

from usdsdg.annotators.annotator import Annotator
from usdsdg.annotators.augmentations.array_transform import ArrayTransform, augmentations
from usdsdg.annotators.named_annotators import augment
from usdsdg.errors import AugmentationError


class Augmentation(ArrayTransform):
    """A function of an annotator's array, with its arguments. Mirrors `rep.annotators.Augmentation`."""

    def apply(self, annotator: Annotator | str, name: str | None = None, **kwargs: Any) -> Annotator:
        """Return a new annotator: `annotator` (object or name) passed through this augmentation.

        Raises:
            AugmentationError: `annotator` is neither an annotator nor a name.
        """
        if not isinstance(annotator, (str, Annotator)):
            raise AugmentationError(f"{annotator!r} is no annotator: give a name, or what annotators.get returns.")
        source = annotator.copy() if isinstance(annotator, Annotator) else annotator
        return augment(source, self, name=name, **kwargs)


def get_augmentation(name: str) -> Augmentation:
    """Return a registered augmentation, or one of Replicator's (defaults.py).

    Raises:
        NoAugmentation: there is no such augmentation; the message lists near misses.
    """
    found = augmentations.get(name)
    assert isinstance(found, Augmentation)
    return found


def register_augmentation(name: str, augmentation: Any) -> None:
    """Make an augmentation (or a function, a registered name, or the type of a node) available under `name`.

    Raises:
        NoAugmentation: there is no augmentation of that name.
        AugmentationError: it is none of these.
    """
    augmentations.add(name, Augmentation.of(augmentation))


def unregister_augmentation(name: str) -> None:
    """Remove an augmentation from the registry.

    Raises:
        NoAugmentation: there is no such augmentation; the message lists near misses.
    """
    augmentations.remove(name)
