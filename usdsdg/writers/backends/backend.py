"""What a backend is: it stores blobs by relative path and runs jobs on the I/O queue."""

import functools
import os
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from typing import Any

from usdsdg.errors import WriterArgumentError
from usdsdg.session.session import current
from usdsdg.snapshots import snapshot
from usdsdg.writers import files
from usdsdg.writers.backends.sequential import Deferred, Sequential, computed, takes_backend


class BaseBackend:
    """Base of all backends. Subclasses implement `write_blob` and, if possible, `read_blob`."""

    def initialize(self, **kwargs: Any) -> None:
        """Run `__init__`, for a backend that came from `get`."""
        self.__init__(**kwargs)

    def write_blob(self, path: str, data: bytes) -> None:
        """Store `data` under `path` atomically.

        Raises:
            NotImplementedError: the subclass does not implement it.
        """
        raise NotImplementedError(f"{self.get_name()} does not write blobs")

    def read_blob(self, path: str) -> bytes:
        """Return what `write_blob` stored under `path`.

        Raises:
            NotImplementedError: the subclass does not implement it.
        """
        raise NotImplementedError(f"{self.get_name()} does not read blobs")

    def write_chunks(self, path: str, chunks: Iterable[bytes | memoryview]) -> None:
        """Store the bytes of `chunks`, one after the other, under `path` atomically.

        chunks: may be gone over several times, so it is no generator.

        Calls `write_blob`; a backend that can do without a copy of large files in one piece overrides it.
        """
        self.write_blob(path, b"".join(chunks))

    def schedule(self, fn: Callable[..., None], *args: Any, **kwargs: Any) -> None:
        """Call `fn(*args, **kwargs)` later on another thread, with `backend_instance=self` if it accepts that.

        `fn` may be a `Sequential`, and arguments may be calls of one. Arrays, lists and dictionaries that a script's
        `Writer.write` schedules are copied; others must not be modified afterward. Blocks while the queue is full;
        raises the error of an earlier job of this backend that failed. Jobs run several at a time: those that need an
        order have `schedule_together`, `schedule_in_turn` and `schedule_after_all`.
        """
        self._submit(fn, args, kwargs)

    def schedule_together(self, steps: Sequence[Callable[..., None]]) -> None:
        """Run `steps` in order as one job, so that a file that names others is written last; an error skips the rest.

        Each step is a `functools.partial` of a function that takes `backend_instance`.
        """
        self.schedule(_run_in_order, steps=tuple(steps))

    def schedule_in_turn(self, turn: Hashable, fn: Callable[..., None], *args: Any, **kwargs: Any) -> None:
        """As `schedule`, one after the other in this order with the jobs of the same `turn`: what appends to a file.

        So are jobs of other backends that write to the same place.
        """
        self._submit(fn, args, kwargs, turn=(self._place(), turn))

    def schedule_after_all(self, fn: Callable[..., None], *args: Any, **kwargs: Any) -> None:
        """As `schedule`, after all earlier jobs of this backend, without waiting here: a file that names others.

        It is left out if one of them fails, so that what is listed exists.
        """
        self._submit(fn, args, kwargs, after_all=True)

    def _place(self) -> Hashable:
        """Return what backends of one place have in common."""
        return id(self)  # where a backend of a script writes is not known

    def _submit(self, fn: Callable[..., None], args: Any, kwargs: dict[str, Any], **order: Any) -> None:
        if current().io_queue.copies_arguments:
            args, kwargs = _copied(tuple(args)), _copied_each(kwargs)
        paths = _paths_of(args, kwargs)
        what = paths[0] if paths else _name_of(fn)
        current().io_queue.note_files(paths)
        files.load_encoders(paths)
        fn = fn.run if isinstance(fn, Sequential) else fn
        if takes_backend(fn):
            kwargs.setdefault("backend_instance", self)
        job = functools.partial(_call, fn, *args, **kwargs)
        current().io_queue.submit(job, what=what, size=_size_of((args, kwargs)), owner=self, **order)

    def is_done_writing(self) -> bool:
        """Return whether no job of this backend waits or runs."""
        return current().io_queue.is_done_writing(self)

    def wait_until_done(self) -> None:
        """Block until everything is written; raises the first failure (a WriterError)."""
        current().io_queue.wait_until_done(self)

    def get_name(self) -> str:
        """Return the name of its class."""
        return type(self).__name__

    # Replicator's older interface: one method per kind of file.

    def write_image(self, path: str, data: Any, **options: Any) -> None:
        """Schedule an image; arguments and errors are those of `functional.write_image`."""
        self.schedule(files.write_image, path=checked_name(path, "write_image"), data=data, **options)

    def write_array(self, path: str, data: Any) -> None:
        """Schedule a .npy array; see `functional.write_np`."""
        self.schedule(files.write_np, path=checked_name(path, "write_array"), data=data)

    def write_exr(self, path: str, data: Any, **options: Any) -> None:
        """Schedule an EXR image; arguments and errors are those of `functional.write_exr`."""
        self.schedule(files.write_exr, path=checked_name(path, "write_exr"), data=data, **options)


def checked_name(path: Any, function: str) -> Any:
    """Return the path of a file that a method of backends was given.

    Raises:
        WriterArgumentError: it is no path, as where path and data have changed places.
    """
    if isinstance(path, (str, os.PathLike)):
        return path
    raise WriterArgumentError(f"{function}: path is of type {type(path).__name__}; give a path first, then the data.")


def checked_blob(path: str, data: Any) -> Any:
    """Return what `write_blob` shall store.

    Raises:
        WriterArgumentError: it is no bytes.
    """
    try:
        memoryview(data)
    except TypeError:
        remedy = "encode text by its encode()" if isinstance(data, str) else "other data by json.dumps(data).encode()"
        raise WriterArgumentError(f"{path}: write_blob takes bytes, not {type(data).__name__}; {remedy}.") from None
    return data


def _call(fn: Callable[..., None], /, *args: Any, **kwargs: Any) -> None:
    """Call `fn` with arguments of which some may be deferred."""
    fn(*map(computed, args), **{name: computed(value) for name, value in kwargs.items()})


def _run_in_order(steps: Sequence[Callable[..., None]], backend_instance: BaseBackend) -> None:
    for step in steps:
        step(backend_instance=backend_instance)


def _copied(value: Any) -> Any:
    """Return a copy of plain data, also of what calls are made with that have not happened yet."""
    if type(value) is tuple:
        return tuple(map(_copied, value))
    if isinstance(value, functools.partial):
        keywords = {name: _copied(each) for name, each in value.keywords.items()}
        return functools.partial(value.func, *map(_copied, value.args), **keywords)
    if isinstance(value, Deferred):
        return Deferred(
            value.sequence, _copied(value.args), {name: _copied(each) for name, each in value.kwargs.items()}
        )
    return snapshot(value)


def _copied_each(values: Mapping[str, Any]) -> dict[str, Any]:
    return {name: _copied(value) for name, value in values.items()}


def _path_of(args: Sequence[Any], kwargs: Mapping[str, Any]) -> str | None:
    """Return the path of the file that a job writes, if its arguments tell."""
    path = kwargs.get("path") or (args[0] if args else None)
    return str(path) if isinstance(path, (str, os.PathLike)) else None


def _paths_of(args: Sequence[Any], kwargs: Mapping[str, Any]) -> list[str]:
    """Return the paths of the files that a job writes, also those of its steps."""
    steps = [each for each in kwargs.get("steps", ()) if isinstance(each, functools.partial)]
    paths = [_path_of(args, kwargs), *(_path_of(step.args, step.keywords) for step in steps)]
    return [path for path in paths if path]


def _name_of(fn: Callable) -> str:
    return getattr(fn, "__name__", repr(fn))


def _size_of(value: Any, depth: int = 4) -> int:
    """Estimate the bytes of the arrays and texts in `value`."""
    if isinstance(value, (bytes, bytearray, str)):
        return len(value)
    if isinstance(size := getattr(value, "nbytes", None), int):  # NumPy's and PyTorch's
        return size
    if depth and isinstance(value, Deferred):
        return _size_of((value.args, value.kwargs), depth - 1)
    if depth and isinstance(value, functools.partial):
        return _size_of((value.args, value.keywords), depth - 1)
    if depth and isinstance(value, Mapping):
        return sum(_size_of(item, depth - 1) for item in value.values())
    if depth and isinstance(value, (list, tuple)):
        return sum(_size_of(item, depth - 1) for item in value)
    return 0
