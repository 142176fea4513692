"""Where bytes go. A backend takes blobs by relative path; writers hand it jobs, which run on the I/O queue."""

from __future__ import annotations

import functools
import inspect
import itertools
import os
import weakref
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from usdsdg.errors import Unsupported, WriterError, WriterRegistryError, warn_once
from usdsdg.registry import Registry
from usdsdg.writers import files
from usdsdg.writers.io_queue import io_queue
from usdsdg.writers.whole_file import check_writable, write_whole

_disk_root: Path | None = None


def set_disk_root(path: str | os.PathLike | None) -> None:
    """The folder that relative output folders are under (setting /omni/replicator/backends/disk/root_dir)."""
    global _disk_root
    _disk_root = None if path is None else Path(path).expanduser()


def disk_root() -> Path:
    """The folder that relative output folders are under; without a setting ~/omni.replicator_out."""
    return _disk_root or Path.home() / "omni.replicator_out"


class BaseBackend:
    """A place for files. Subclasses write `write_blob` and, if they can, `read_blob`."""

    def initialize(self, **kwargs: Any) -> None:
        """Run `__init__` again, for a backend that came from `get`."""
        self.__init__(**kwargs)

    def write_blob(self, path: str, data: bytes) -> None:
        """Store `data` under `path`, wholly or not at all."""
        raise NotImplementedError(f"{self.get_name()} does not write blobs")

    def read_blob(self, path: str) -> bytes:
        """What `write_blob` stored under `path`."""
        raise NotImplementedError(f"{self.get_name()} does not read blobs")

    def schedule(self, fn: Callable[..., None], *args: Any, **kwargs: Any) -> None:
        """Call `fn(*args, **kwargs)` soon on another thread, with `backend_instance=self` if it takes that.

        The arguments must not change any more. Blocks while the queue is full; raises what an earlier job of this
        backend failed with.
        """
        what = str(kwargs.get("path") or (args[0] if args and isinstance(args[0], str) else _name_of(fn)))
        if _takes_backend(fn):
            kwargs.setdefault("backend_instance", self)
        job = functools.partial(fn, *args, **kwargs)
        io_queue.submit(job, what=what, size=_size_of((args, kwargs)), owner=self)

    def schedule_together(self, steps: Sequence[Callable[..., None]]) -> None:
        """Run `steps` one after the other as one job: a file that names others goes last, and if one fails the rest are
        not written. Each step is a `functools.partial` of a function that takes `backend_instance`.
        """
        self.schedule(_run_in_order, steps=tuple(steps))

    def is_done_writing(self) -> bool:
        """Whether nothing of this backend waits or runs."""
        return io_queue.is_done_writing(self)

    def wait_until_done(self) -> None:
        """Return when all is written; raises the first failure (a WriterError)."""
        io_queue.wait_until_done(self)

    def get_name(self) -> str:
        return type(self).__name__

    # The older spelling: one method per kind of file.

    def write_image(self, path: str, data: Any, **options: Any) -> None:
        """Schedule a picture."""
        self.schedule(files.write_image, path=path, data=data, **options)

    def write_array(self, path: str, data: Any) -> None:
        """Schedule a .npy array."""
        self.schedule(files.write_np, path=path, data=data)

    def write_exr(self, path: str, data: Any, **options: Any) -> None:
        """Schedule an EXR picture."""
        self.schedule(files.write_exr, path=path, data=data, **options)


class DiskBackend(BaseBackend):
    """Files in a folder of this machine."""

    def __init__(self, output_dir: str | os.PathLike, overwrite: bool = True) -> None:
        """Make the folder; warns where it has files already.

        output_dir: a relative one lies under `disk_root()`.
        overwrite: False puts the files into a new folder beside an existing one, with _0001 (and so on) appended.

        Raises:
            OutputNotWritable: the folder cannot be made or written to.
        """
        folder = disk_root() / Path(output_dir).expanduser()
        self._folder = folder if overwrite else _free_folder(folder)
        check_writable(self._folder)
        _warn_of_leftovers(self._folder)

    @property
    def output_dir(self) -> str:
        """The folder, absolute."""
        folder = self.__dict__.get("_folder")
        if folder is None:
            raise WriterError("This DiskBackend has no folder yet: call initialize(output_dir=...) first.")
        return str(folder)

    def resolve_path(self, path: str) -> str:
        """The absolute path of a file of this backend."""
        return os.path.join(self.output_dir, path)

    def write_blob(self, path: str, data: bytes) -> None:
        _warn_of_sharing(self)
        write_whole(Path(self.resolve_path(path)), data)

    def read_blob(self, path: str) -> bytes:
        return Path(self.resolve_path(path)).read_bytes()


class BackendGroup(BaseBackend):
    """Several backends that all get everything."""

    def __init__(self, backends: Sequence[BaseBackend]) -> None:
        self._backends = list(backends)

    @property
    def output_dir(self) -> str:
        """The folder of the first backend that has one."""
        for backend in self._backends:
            if hasattr(backend, "output_dir"):
                return backend.output_dir  # type: ignore[attr-defined]
        raise WriterError("None of the backends of this group writes into a folder.")

    def write_blob(self, path: str, data: bytes) -> None:
        for backend in self._backends:
            backend.write_blob(path, data)

    def read_blob(self, path: str) -> bytes:
        return self._backends[0].read_blob(path)

    def schedule(self, fn: Callable[..., None], *args: Any, **kwargs: Any) -> None:
        for backend in self._backends:
            backend.schedule(fn, *args, **kwargs)

    def is_done_writing(self) -> bool:
        return all(backend.is_done_writing() for backend in self._backends)

    def wait_until_done(self) -> None:
        for backend in self._backends:
            backend.wait_until_done()


class BackendDispatch(BackendGroup):
    """A backend from loose arguments, as older writers make it."""

    def __init__(
        self,
        config: Mapping[str, Any] | None = None,
        output_dir: str | os.PathLike | None = None,
        key_prefix: str | None = None,
        bucket: str | None = None,
        region: str | None = None,
        endpoint_url: str | None = None,
        overwrite: bool = True,
    ) -> None:
        """config: {"paths": {"out_dir": folder}}, an alternative to `output_dir`."""
        paths = (config or {}).get("paths", {})
        folder = output_dir or paths.get("out_dir")
        if bucket := bucket or paths.get("s3_bucket"):
            S3Backend(bucket, key_prefix, region, endpoint_url, overwrite)
        if not folder:
            raise WriterError("BackendDispatch has nowhere to write: give output_dir.")
        super().__init__([DiskBackend(folder, overwrite)])

    @staticmethod
    def set_max_queue_size(jobs: int) -> None:
        """How many jobs of all backends may wait before `schedule` blocks."""
        io_queue.set_max_queue_size(jobs)


class S3Backend(BaseBackend):
    """Unsupported: object storage."""

    def __init__(
        self,
        bucket: str,
        key_prefix: str | None,
        region: str | None = None,
        endpoint_url: str | None = None,
        overwrite: bool = False,
    ) -> None:
        raise Unsupported(
            f"S3 bucket {bucket!r}: writing to S3 needs the extra 's3', which this version does not have yet. Write "
            "to a folder (output_dir) and copy it."
        )


registered: Registry[type[BaseBackend]] = Registry("backend", WriterRegistryError)


def register(backend: type[BaseBackend]) -> None:
    registered.add(backend.__name__, backend)


def unregister(name: str) -> None:
    registered.remove(name)


def get(name: str, init_params: Mapping[str, Any] | None = None) -> BaseBackend:
    """A backend by name; without `init_params` it still has to be initialised."""
    kind = registered.get(name)
    backend = kind.__new__(kind)
    if init_params is not None:
        backend.initialize(**init_params)
    return backend


def make_backend(
    writer: str, output_dir: Any, backend: BaseBackend | None, *, bucket: str | None = None, region: str | None = None
) -> BaseBackend:
    """Where a writer writes: the backend given, the folder, or both.

    Raises:
        WriterError: neither is given, or the backend is none.
    """
    if backend is not None and not isinstance(backend, BaseBackend):
        raise WriterError(
            f"{writer}: backend must be a BaseBackend, such as backends.get('DiskBackend'); got {backend!r}."
        )
    folder = BackendDispatch(output_dir=output_dir, bucket=bucket, region=region) if output_dir or bucket else None
    if folder is None and backend is None:
        raise WriterError(f"{writer} has nowhere to write: give output_dir, or backend.")
    if folder is None or backend is None:
        return backend or folder  # type: ignore[return-value]
    known = backend._backends if isinstance(backend, BackendGroup) else [backend]
    return BackendGroup([*known, *folder._backends])


class BackendRegistry:
    """The same under Replicator's names."""

    register_backend = staticmethod(register)
    unregister_backend = staticmethod(unregister)
    get_backend = staticmethod(get)
    get_registered_backends = staticmethod(registered.names)


for _kind in (DiskBackend, S3Backend, BackendGroup):
    register(_kind)


def _free_folder(folder: Path) -> Path:
    candidates = (folder.with_name(f"{folder.name}_{number:04d}") for number in itertools.count(1))
    return next((path for path in candidates if not path.exists()), folder) if folder.exists() else folder


def _warn_of_leftovers(folder: Path) -> None:
    """Files of an earlier, longer run would stay among the new ones."""
    if any(folder.iterdir()):
        warn_once(
            f"{folder} is not empty: files of the same names are replaced, the others stay. "
            "Empty it or give another output_dir to keep runs apart."
        )


# The first backend of this process that wrote into a folder, as long as it lives.
_writing: weakref.WeakValueDictionary[str, DiskBackend] = weakref.WeakValueDictionary()


def _warn_of_sharing(backend: DiskBackend) -> None:
    """Two writers that were initialised with one folder replace each other's files."""
    if _writing.setdefault(backend.output_dir, backend) is not backend:
        warn_once(
            f"{backend.output_dir} is written to by several writers: files of the same names, such as metadata.txt, "
            "replace each other. Give each writer an output_dir of its own."
        )


def _run_in_order(steps: Sequence[Callable[..., None]], backend_instance: BaseBackend) -> None:
    for step in steps:
        step(backend_instance=backend_instance)


@functools.lru_cache(maxsize=256)
def _takes_backend(fn: Callable) -> bool:
    try:
        parameters = inspect.signature(fn).parameters.values()
    except (TypeError, ValueError):  # built-ins need not have one
        return False
    return any(p.name == "backend_instance" or p.kind is p.VAR_KEYWORD for p in parameters)


def _name_of(fn: Callable) -> str:
    return getattr(fn, "__name__", repr(fn))


def _size_of(value: Any, depth: int = 4) -> int:
    """Bytes of the arrays in `value`, roughly."""
    if isinstance(value, np.ndarray):
        return value.nbytes
    if isinstance(value, (bytes, bytearray)):
        return len(value)
    if depth and isinstance(value, functools.partial):
        return _size_of((value.args, value.keywords), depth - 1)
    if depth and isinstance(value, Mapping):
        return sum(_size_of(item, depth - 1) for item in value.values())
    if depth and isinstance(value, (list, tuple)):
        return sum(_size_of(item, depth - 1) for item in value)
    return 0
