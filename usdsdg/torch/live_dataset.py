"""LiveDataset: the frames of a job as samples for a trainer, without files."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import torch  # pyright: ignore[reportMissingImports]
from torch.utils.data import (  # pyright: ignore[reportMissingImports]
    IterableDataset,
    get_worker_info,
)

from usdsdg import stream
from usdsdg.errors import ArgumentError
from usdsdg.session import session
from usdsdg.stream import Sample, Source
from usdsdg.stream.stream import checked_part
from usdsdg.torch.tensors import tensors


class LiveDataset(IterableDataset):
    """The frames of a configuration or a script as samples, rendered while the trainer takes them.

    A sample is a dict: "frame" (int), "render_product" and "camera" (str), "info" (what annotators return besides
    arrays, by annotator), "classes" (the class table: labels by id), and each annotator's array as a tensor under its
    name. Records, such as boxes, are a dict of tensors by field, with "classId", the row's id in "classes", where they
    have labels. Where annotators have several label filters, "classes" is of the first one with labels, and
    "class_tables" has the tables of those with other filters, by annotator. `transform` turns a sample into what the
    trainer wants.

    With `DataLoader(dataset, batch_size=..., num_workers=n)` worker i makes the frames i, i + n, i + 2n, ...: frame k
    is the same for any n, since graph and physics of all frames run in every worker. Processes that train one network
    together each take a part, `part=(rank, world_size)`; else all of them train on the same frames. Each epoch repeats
    the frames of its seed; `set_epoch` asks for others. With num_workers=0 the job runs in a thread of the trainer's
    own process, in which no stage may be open, and seeds Python's and NumPy's generators.

    With `worlds=n` a sample is a whole batch: what n worlds show, made together and left on the device, as tensors
    with a leading axis of worlds (see `usdsdg.stream.worlds`). It has "frame", "render_product", "camera", "classes",
    "prims" (the paths of the labeled prims), "class_ids" (of these, int64 (prims,)) and the arrays under their names;
    "bounding_box_2d_tight" is int32 (worlds, prims, 5). This needs num_workers=0, and
    a trainer on the default stream of the device, with which the renderer keeps step when memory is used again.

    Example:
        >>> annotators = ["rgb", "bounding_box_2d_tight"]
        >>> dataset = LiveDataset("configs/detection.yaml", annotators, arguments=["num_frames=64"])
        >>> for batch in DataLoader(dataset, batch_size=None, num_workers=1):
        ...     train(batch["rgb"], batch["bounding_box_2d_tight"])
    """

    def __init__(
        self,
        job: str | os.PathLike[str],
        annotators: Sequence[Any] = ("rgb",),
        *,
        arguments: Sequence[str] = (),
        seed: int | None = None,
        part: tuple[int, int] = (0, 1),
        device: Any = "cpu",
        transform: Callable[[dict[str, Any]], Any] | None = None,
        ahead: int = 2,
        worlds: int | None = None,
    ) -> None:
        """
        job: a configuration of `usdsdg generate`, or a script of `usdsdg run`.
        annotators: their names, as for `rep.annotators.get`, or pairs (name, init_params).
        arguments: "key=value" overrides of the configuration, or the arguments of the script.
        seed: of the first epoch; None: the configuration's, 0 for a script.
        part: (i, n) takes the frames i, i + n, i + 2n and so on, which the workers share.
        device: where the tensors of samples are, as torch names devices; a DataLoader's workers that pass tensors on
            CUDA need the start method "spawn".
        transform: what samples are passed through, in the worker.
        ahead: how many samples a worker makes before they are asked for.
        worlds: how many worlds a sample is of; None: samples are of one frame each.

        Raises:
            ArgumentError: one text was given in place of a list, `part` is none, or was given with `worlds`, or torch
                names no device as `device`.
        """
        for name, given in (("annotators", annotators), ("arguments", arguments)):
            if isinstance(given, str):
                raise ArgumentError(f"LiveDataset: {name} is the text {given!r}; give a list, such as [{given!r}]")
        self.job, self.annotators, self.arguments = os.fspath(job), tuple(annotators), tuple(arguments)
        self.seed = None if seed is None else int(seed)
        self.part = checked_part(part, who="LiveDataset")
        if worlds is not None and self.part[1] > 1:
            raise ArgumentError("LiveDataset: worlds have all frames, and no part; give each process a seed of its own")
        self.device, self.transform, self.ahead = _device(device), transform, ahead
        self.worlds = worlds
        self._epoch = torch.zeros((), dtype=torch.int64).share_memory_()  # which workers see change

    def set_epoch(self, epoch: int) -> None:
        """Take the frames of another seed, `seed` + `epoch`, from the next iteration on."""
        self._epoch.fill_(int(epoch))

    def __iter__(self) -> Iterator[Any]:
        """Run the job, and yield its samples.

        Raises:
            as `usdsdg.stream.frames`.
        """
        worker = get_worker_info()
        if self.worlds is not None:
            yield from self._batches(self.worlds, worker)
            return
        if worker is not None:
            session.restart()  # a forked worker has a copy of the trainer's session
        samples = stream.frames(
            self.job,
            self.annotators,
            arguments=self.arguments,
            seed=self._seed_of_epoch(),
            part=self._part_of(worker),
            ahead=self.ahead,
        )
        for sample in samples:
            yield self._made(sample)

    def _seed_of_epoch(self) -> int | None:
        epoch = int(self._epoch)
        return Source(Path(self.job), self.arguments, self.seed).seed_of_run + epoch if epoch else self.seed

    def _part_of(self, worker: Any) -> tuple[int, int]:
        first, step = self.part
        return self.part if worker is None else (first + step * worker.id, step * worker.num_workers)

    def _batches(self, count: int, worker: Any) -> Iterator[Any]:
        if worker is not None:
            raise ArgumentError(
                "LiveDataset: worlds stay on the device of the process that trains; use DataLoader(..., num_workers=0)"
            )
        device = self.device
        name = f"cuda:{device.index or 0}" if device.type == "cuda" else "cpu"
        options: dict[str, Any] = {"arguments": self.arguments, "seed": self._seed_of_epoch(), "device": name}
        for batch in stream.worlds(self.job, self.annotators, count=count, ahead=self.ahead, **options):
            batch.wait()
            yield self._batch_made(batch)

    def _batch_made(self, batch: stream.WorldBatch) -> Any:
        import warp as wp  # loaded by then, and not by those who only import this

        # Not by DLPack: what Warp then calls once a tensor is gone fails where an exception is on its way, as where a
        # generator is closed that holds the tensor.
        pictures = {key: wp.to_torch(array).to(self.device) for key, array in batch.arrays.items()}
        made = {
            "frame": batch.frame,
            "render_product": batch.render_product,
            "camera": batch.camera,
            "prims": batch.prims,
            "class_ids": torch.from_numpy(batch.class_ids).to(self.device),
            "classes": _plain(batch.classes),
            **pictures,
        }
        return made if self.transform is None else self.transform(made)

    def _made(self, sample: Sample) -> Any:
        arrays = tensors(sample.arrays, self.device)
        for name, array in arrays.items():
            if isinstance(array, dict) and "semanticId" in array:
                array["classId"] = torch.from_numpy(sample.class_ids(name)).to(self.device)
        made = {
            "frame": sample.frame,
            "render_product": sample.render_product,
            "camera": sample.camera,
            "info": {name: dict(info) for name, info in sample.infos.items() if info},
            "classes": _plain(sample.classes),
            **arrays,
        }
        if sample.class_tables:
            made["class_tables"] = {name: _plain(table) for name, table in sample.class_tables.items()}
        return made if self.transform is None else self.transform(made)


def _device(named: Any) -> torch.device:
    try:
        return torch.device("cpu" if named is None else named)
    except (TypeError, RuntimeError):
        raise ArgumentError(
            f"LiveDataset: device is {named!r}; expected a device of torch, such as 'cpu' or 'cuda'"
        ) from None


def _plain(table: Mapping[int, Mapping[str, str]]) -> dict[int, dict[str, str]]:
    return {number: dict(labels) for number, labels in table.items()}
