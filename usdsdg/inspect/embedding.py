"""Selection and size of the images on the page, so that the page stays loadable."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np

from usdsdg.inspect import image_encoding, problems
from usdsdg.inspect.image_encoding import Encoded
from usdsdg.inspect.layers import layers
from usdsdg.inspect.records import Dataset, Frame, Problem

Progress = Callable[[str, int, int | None], None]

# Longest side in pixels; the largest that fits is used.
SIZES = (960, 720, 540, 400)
BUDGET = 42_000_000
# Frames that are encoded to estimate the size of all.
PROBES = 4
# Pixels by which a box may reach out of the picture: formats have a few digits.
_ROUNDED = 0.01


@dataclass
class Shown:
    """A frame with its encoded images; `size` is the original (width, height), if any image is readable."""

    frame: Frame
    size: tuple[int, int] | None = None
    picture: Encoded | None = None
    layers: dict[str, Encoded] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)

    @property
    def bytes(self) -> int:
        """Size in the page: base64 encodes three bytes as four characters."""
        parts = [*self.layers.values(), *([self.picture] if self.picture else [])]
        return sum(len(part.data) for part in parts) * 4 // 3


@dataclass(frozen=True)
class Embedding:
    """The frames on the page, in order, and a note about omitted or downscaled ones."""

    shown: list[Shown]
    note: str | None


def embed(dataset: Dataset, *, budget: int = BUDGET, progress: Progress | None = None) -> Embedding:
    """Encode the images of all frames, or of as many as fit into `budget` bytes, at the largest size that fits.

    Problems with images are added to the dataset.
    """
    frames = dataset.frames
    longest, per_frame = _largest_size(dataset, budget)
    capacity = max(1, int(budget / max(per_frame, 1)))
    chosen = frames if len(frames) <= capacity else _evenly_chosen(dataset, capacity)
    with ThreadPoolExecutor(max_workers=4) as pool:
        shown = []
        for made in pool.map(lambda frame: _encode(frame, longest), chosen):
            shown.append(made)
            if progress is not None:
                progress("pictures", len(shown), len(chosen))
    for made in shown:
        dataset.problems.extend(made.problems)
    _check_unshown(dataset, {id(frame) for frame in chosen})
    for part, folder in {frame.part: frame.folder for frame in frames}.items():
        problems.add_faults(dataset, part, folder)
    _check_sizes(dataset, shown)
    return Embedding(shown, _note(len(frames), shown, longest))


def _largest_size(dataset: Dataset, budget: int) -> tuple[int, float]:
    """Return the size to encode at, and the bytes per frame at that size."""
    probes = [dataset.frames[i] for i in np.unique(np.linspace(0, len(dataset.frames) - 1, PROBES).astype(int))]
    mean = 0.0
    for longest in SIZES:
        mean = sum(_encode(frame, longest).bytes for frame in probes) / len(probes)
        # With a margin, since other frames may compress less well than the probes.
        if 1.15 * mean * len(dataset.frames) <= budget:
            return longest, mean
    return SIZES[-1], 1.15 * mean


def _evenly_chosen(dataset: Dataset, capacity: int) -> list[Frame]:
    """Choose `capacity` frames: up to a quarter with problems, the others evenly spaced."""
    frames = dataset.frames
    odd = {problem.frame for problem in dataset.problems if problem.kind != "empty frame"}
    wanted = [frame for frame in frames if frame.name in odd][: max(1, capacity // 4)]
    step = np.linspace(0, len(frames) - 1, max(1, capacity - len(wanted))).astype(int)
    chosen = {id(frame) for frame in [*wanted, *(frames[i] for i in step)]}
    return [frame for frame in frames if id(frame) in chosen]


def _encode(frame: Frame, longest: int) -> Shown:
    shown, seen = Shown(frame), frame.seen.complete()
    if seen.colors:
        shown.picture = image_encoding.photograph(seen.colors[0].image, longest)
        shown.size = (seen.colors[0].image.shape[1], seen.colors[0].image.shape[0])
    for layer in layers(seen, frame.objects):
        shown.layers[layer.kind] = layer.draw(longest)
        if shown.size is None:
            shown.size = layer.size
        elif shown.size != layer.size:
            text = (
                f"{frame.path(layer.file)} is {layer.size[0]} x {layer.size[1]}, the picture {shown.size[0]} x "
                f"{shown.size[1]} pixels"
            )
            shown.problems.append(Problem("sizes differ", text, frame.name))
    return shown


def _check_unshown(dataset: Dataset, shown: set[int]) -> None:
    """Check that at least the header of every omitted image is readable."""
    for frame in dataset.frames:
        if id(frame) not in shown and frame.seen.picture and frame.folder.has(frame.seen.picture):
            frame.folder.image_size(frame.seen.picture, frame.seen.name)


def _check_sizes(dataset: Dataset, shown: Sequence[Shown]) -> None:
    """Check that all images of a view have the same size and contain their boxes."""
    usual: dict[str, tuple[int, int]] = {}
    for each in shown:
        if each.size is None:
            continue
        first = usual.setdefault(each.frame.view, each.size)
        if each.size != first:
            text = f"{each.frame.name} is {each.size[0]} x {each.size[1]}, the first one {first[0]} x {first[1]} pixels"
            dataset.problems.append(Problem("sizes differ", text, each.frame.name))
        for seen in each.frame.objects:
            box = seen.box
            if box and min(box[0], box[1], each.size[0] - box[2], each.size[1] - box[3]) < -_ROUNDED:
                text = f"{each.frame.name}: the box of {seen.prim_path or seen.label} reaches outside the picture"
                dataset.problems.append(Problem("box outside the picture", text, each.frame.name))


def _note(frames: int, shown: Sequence[Shown], longest: int) -> str | None:
    """Describe what was omitted or downscaled to keep the page small; None if nothing was."""
    smaller = any(each.size and max(each.size) > longest for each in shown)
    parts = []
    if len(shown) < frames:
        parts.append(
            f"{len(shown)} of {frames} pictures {'is' if len(shown) == 1 else 'are'} on this page, evenly chosen; "
            "counts and histograms are of all"
        )
    if smaller:
        parts.append(f"pictures are shown at most {longest} pixels long; numbers are the originals'")
    return ". ".join(part[0].upper() + part[1:] for part in parts) + "." if parts else None
