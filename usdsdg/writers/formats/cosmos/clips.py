"""The videos of a clip, made of the pictures that a backend has stored."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping

import numpy as np

from usdsdg.errors import warn_once
from usdsdg.image_files.motion_jpeg import Video, encode_frame
from usdsdg.session.session import current
from usdsdg.writers.aggregate import Aggregate, Texts
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.group import BackendGroup
from usdsdg.writers.spool import Records

MODALITIES = ("rgb", "shaded_seg", "segmentation", "depth", "edges")


class Clip(Aggregate):
    """The videos of one clip.

    A record has the "number" of a frame in the clip, and the "sizes" of its pictures by the folder of their render
    product, with a slash or "". Of all frames are known the number of the "clip" and the "rate" of the videos.
    """

    def __init__(self, backend: BaseBackend, number: int) -> None:
        self.number = number
        super().__init__(backend, f"CosmosWriter/clip_{number:04d}")

    @staticmethod
    def files(records: Records) -> Mapping[str, Texts]:
        """Return nothing: the files are no texts."""
        return {}

    @classmethod
    def schedule(cls, records: Records, backend: BaseBackend) -> None:
        if not _can_read(backend):
            warn_once(f"CosmosWriter: {backend.get_name()} has no read_blob, so only images are written, no videos.")
            return
        _warn_of_other_sizes(records)
        with current().io_queue.of_all_frames():
            for path, root, modality, size in _videos(records):
                what = {"records": records, "root": root, "modality": modality, "size": size}
                backend.schedule_after_all(_write_video, path=path, **what)

    @classmethod
    def paths(cls, records: Records) -> list[str]:
        return [path for path, *_ in _videos(records)]


def _videos(records: Records) -> Iterator[tuple[str, str, str, tuple[int, int]]]:
    """Yield of each video the path, the folder of the render product, the modality, and the size of its pictures."""
    sizes: dict[str, tuple[int, int]] = {}
    for each in records:
        sizes = each["sizes"] | sizes  # those of the first pictures
    for root, size in sorted(sizes.items()):
        for modality in MODALITIES:
            yield f"{root}clip_{records.about['clip']:04d}/{modality}.mp4", root, modality, size


def picture_of(root: str, clip: int, modality: str, number: int) -> str:
    """Return the file of a picture. root: folder of the render product, with a slash, or ""."""
    return f"{root}clip_{clip:04d}/{modality}/{modality}_{number:04d}.png"


def _can_read(backend: BaseBackend) -> bool:
    if isinstance(backend, BackendGroup):
        return all(map(_can_read, backend.backends))
    return type(backend).read_blob is not BaseBackend.read_blob


def _write_video(
    path: str, records: Records, root: str, modality: str, size: tuple[int, int], backend_instance: BaseBackend
) -> None:
    """Write the video of a clip's pictures, which the backend has stored; one is in memory at a time."""
    video = Video((size[0], size[1]), records.about["rate"])
    for picture in _pictures(records, root, modality, size, backend_instance):
        video.append(encode_frame(picture))
    backend_instance.write_chunks(path, video)


def _warn_of_other_sizes(records: Records) -> None:
    """Name the pictures that are in no video: all of a video have the size of the first one."""
    first: dict[str, list[int]] = {}
    for each in records:
        for root, size in each["sizes"].items():
            if size != first.setdefault(root, size):
                width, height = first[root]
                warn_once(
                    f"CosmosWriter: the picture {each['number']} of {root}clip_{records.about['clip']:04d} has "
                    f"{size[0]} x {size[1]} pixels and the first one {width} x {height}, so its videos lack it and all "
                    "others of another size. Call next_clip() where the resolution changes."
                )
                return


def _pictures(
    records: Records, root: str, modality: str, size: tuple[int, int], backend: BaseBackend
) -> Iterator[np.ndarray]:
    from PIL import Image

    for each in records:
        if each["sizes"].get(root) == list(size):
            path = picture_of(root, records.about["clip"], modality, each["number"])
            yield np.asarray(Image.open(io.BytesIO(backend.read_blob(path))))
