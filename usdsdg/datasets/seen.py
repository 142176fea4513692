"""What a dataset's files say about one image, independent of their format."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any

import numpy as np

from usdsdg.datasets.truth import Truth


@dataclass(frozen=True)
class Color:
    """A color image, or one that is drawn over."""

    file: str
    image: np.ndarray  # (H, W, 3 or 4) uint8
    exact: bool = True  # stored without loss


@dataclass(frozen=True)
class Ids:
    """An image of ids or of colors, and what they mean."""

    file: str
    kind: str  # "class", "instance", "gprim"; "instance labels" for labels of the ids of instances
    keys: np.ndarray  # (H, W) int64: ids, or colors as one number
    meanings: Mapping[int, str] | None  # by key: labels as one text, or a prim path; None: there is no table
    table: str = ""  # file of the meanings
    colored: bool = False
    filter: str = ""
    chosen: bool = False  # the user chose ids or colors, so several things may share one
    written: Mapping[int, str] = field(default_factory=dict)  # keys as the file writes them


@dataclass(frozen=True)
class Boxes:
    """2D or 3D boxes as rows of an array, with tables."""

    file: str
    kind: str  # "tight", "loose", "3d"
    labels: list[str]
    paths: list[str] | None
    rows: np.ndarray  # structured: x_min ... and occlusionRatio, 3D boxes also transform
    filter: str = ""
    names: Sequence[str] = ()  # the labels as they are shown to people


@dataclass(frozen=True)
class Occlusions:
    """Occluded fractions by id."""

    file: str
    rows: np.ndarray  # structured: instanceId, semanticId, occlusionRatio
    filter: str = ""


@dataclass(frozen=True)
class Depth:
    """Distances."""

    file: str
    kind: str  # "camera": along the ray; "plane": along the optical axis
    values: np.ndarray  # (H, W) meters; infinite where nothing is hit
    step: float = 0.0  # resolution of the format [m]; 0: float32
    far: float = np.inf  # where the format ends


@dataclass(frozen=True)
class Camera:
    """A camera's matrices."""

    file: str
    view: np.ndarray | None  # (4, 4) world to camera; None: the file does not say it
    digits: float  # accuracy of the file's numbers
    size: tuple[int, int] | None = None
    focal: float | None = None  # [pixels], along rows
    center: tuple[float, float] | None = None
    values: Mapping[str, Any] = field(default_factory=dict)  # all that the file has
    focal_down: float | None = None  # [pixels], along columns; None: the same


@dataclass(frozen=True)
class Posed:
    """One object with a pose."""

    path: str
    label: str
    visibility: float
    values: Mapping[str, Any]  # by key of the file


@dataclass(frozen=True)
class Poses:
    """The objects of a pose file."""

    file: str
    objects: list[Posed]
    order: list[str]  # names of the keypoints
    format: str  # "default", "dope", "centerpose"
    exact: bool  # poses in the camera's frame are those of the image
    threshold: float = 0.0


@dataclass(frozen=True)
class Mask:
    """An annotation with a mask."""

    number: int
    category: int
    box: tuple[float, float, float, float]  # x, y, width, height
    area: float
    decode: Callable[[], np.ndarray | None]
    has_holes: bool = True  # False: polygons, in which they are filled
    polygons: list[np.ndarray] = field(default_factory=list)  # (N, 2) corners [pixels]
    keypoints: tuple[list[float], int] | None = None  # x, y, v of each, and how many are in the picture
    crowd: Any = 0  # iscrowd: 1 would be a mask of several things

    @cached_property
    def mask(self) -> np.ndarray | None:
        """The pixels, (H, W) bool; None: they cannot be decoded."""
        return self.decode()


@dataclass(frozen=True)
class Masks:
    """The annotations of one image of a COCO file."""

    file: str
    image: Mapping[str, Any]  # the record of the image
    masks: list[Mask]
    categories: Mapping[int, Mapping[str, Any]]
    own: Mapping[str, Mapping[str, Any]]  # categories that the file must have, by label
    filter: str = ""
    things_only: bool = False  # categories of stuff have no annotations
    by_class: bool = False  # categories are the classes of the dataset, each a set of labels


@dataclass(frozen=True)
class Segments:
    """The segments of one image of a panoptic COCO file."""

    file: str
    picture: str
    ids: np.ndarray  # (H, W) int64; 0 for none
    records: list[Mapping[str, Any]]
    categories: Mapping[int, Mapping[str, Any]]


@dataclass(frozen=True)
class Labeled:
    """One object of a file that has names and boxes; None is what the format does not say."""

    name: str
    box: tuple[float, float, float, float]  # left, top, right and bottom edge [pixels]
    mask: np.ndarray | None = None  # (H, W) bool
    has_holes: bool = True  # False: polygons, in which they are filled
    flags: Mapping[str, bool] = field(default_factory=dict)  # "occluded", "truncated", "difficult"
    instance: int | None = None  # its id in instance_segmentation


@dataclass(frozen=True)
class Points:
    """A point cloud and its companions, by name."""

    file: str
    points: np.ndarray  # (N, 3) in the world
    others: Mapping[str, tuple[str, np.ndarray]]  # kind: file and array
    filter: str
    whole: bool  # points of unlabeled gprims too


@dataclass
class Seen:
    """All files of one image. A format adds what is special to it as `extra`."""

    format: str
    frame: str  # as the files name it
    view: str  # render product, as the files name it; "" for the only one
    files: list[str]
    truth: Truth | None = None
    size: tuple[int, int] | None = None
    variant: str = ""  # of the format, as "dope"
    picture: str = ""  # file of the color image
    labels: str = ""  # file of the labels; "" where there is none or it cannot be read
    undrawn: list[str] = field(default_factory=list)  # kinds of its files that are neither objects nor images
    notes: list[str] = field(default_factory=list)  # what cannot be drawn, and why
    colors: list[Color] = field(default_factory=list)
    ids: list[Ids] = field(default_factory=list)
    boxes: list[Boxes] = field(default_factory=list)
    occlusions: list[Occlusions] = field(default_factory=list)
    depths: list[Depth] = field(default_factory=list)
    cameras: list[Camera] = field(default_factory=list)
    poses: list[Poses] = field(default_factory=list)
    masks: list[Masks] = field(default_factory=list)
    segments: list[Segments] = field(default_factory=list)
    labeled: list[Labeled] = field(default_factory=list)
    points: list[Points] = field(default_factory=list)
    arrays: dict[str, tuple[str, np.ndarray]] = field(default_factory=dict)  # AOVs: name to file and array
    normals: list[Color] = field(default_factory=list)
    lines: list[tuple[str, list[list[str]]]] = field(default_factory=list)  # KITTI's: file and fields of each line
    extra: dict[str, Any] = field(default_factory=dict)
    steps: list[Callable[[Seen], None]] = field(default_factory=list)

    def later(self, step: Callable[[Seen], None]) -> None:
        """Do a step of the reading only where pixels are needed: it decodes images and adds them to what it is given.

        So labels of many images are read without their pixels.
        """
        self.steps.append(step)

    def complete(self) -> Seen:
        """Return the same with all images decoded. This is without them still, so that their memory is not kept."""
        copied = {each.name: copy(getattr(self, each.name)) for each in fields(self)}
        made = Seen(**{**copied, "steps": []})
        for step in self.steps:
            step(made)
        return made

    @property
    def name(self) -> str:
        return f"{self.view}/{self.frame}" if self.view else self.frame

    def further_images(self) -> dict[str, tuple[str, np.ndarray]]:
        """Return the images that only this format has, with their files: those of `extra`."""
        pairs = {name: value for name, value in self.extra.items() if isinstance(value, tuple) and len(value) == 2}
        return {name: pair for name, pair in pairs.items() if isinstance(pair[1], np.ndarray)}


def packed(image: np.ndarray) -> np.ndarray:
    """Return the colors of an image, (H, W, 3 or 4) uint8, as one number each; a missing alpha is 255."""
    channels = image.astype(np.int64)
    alpha = channels[..., 3] if image.shape[2] > 3 else 255
    return ((channels[..., 0] * 256 + channels[..., 1]) * 256 + channels[..., 2]) * 256 + alpha


def unpacked(key: int) -> tuple[int, int, int, int]:
    """Return the color of a number of `packed`."""
    return (key >> 24 & 255, key >> 16 & 255, key >> 8 & 255, key & 255)
