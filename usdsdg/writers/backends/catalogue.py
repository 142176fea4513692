"""Where bytes go: folders, buckets, several places at once; and backends by name (`rep.backends`)."""

from __future__ import annotations

import itertools
import os
import weakref
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from usdsdg.arguments.registry import Registry
from usdsdg.errors import WriterError, WriterRegistryError, warn_once
from usdsdg.session.session import current
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.s3 import S3Backend
from usdsdg.writers.backends.whole_file import check_writable, write_whole
from usdsdg.writers.options import check_names


def set_disk_root(path: str | os.PathLike | None) -> None:
    """The folder that relative output folders are under (setting /omni/replicator/backends/disk/root_dir)."""
    current().disk_root = None if path is None else Path(path).expanduser()


def disk_root() -> Path:
    """The folder that relative output folders are under; without a setting ~/omni.replicator_out."""
    return current().disk_root or Path.home() / "omni.replicator_out"


class DiskBackend(BaseBackend):
    """Files in a folder of this machine. Mirrors `rep.backends.DiskBackend`."""

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
        """The folder, absolute.

        Raises:
            WriterError: the backend was not initialised.
        """
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
    """Several backends that all get everything; read is from the first. Mirrors `rep.backends.BackendGroup`."""

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
    """A backend from loose arguments, as older writers make it. Mirrors `rep.BackendDispatch`."""

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
        """To a folder, to a bucket, or to both.

        config: {"paths": {"out_dir": folder, "s3_bucket": name}}, an alternative to `output_dir` and `bucket`.
        key_prefix: what keys in the bucket begin with; default, `output_dir`, and then no files go into that folder.
        region, endpoint_url: of the bucket; see `S3Backend`.

        Raises:
            WriterError: there is neither a folder nor a bucket.
            OutputNotWritable, Unsupported: as `DiskBackend` and `S3Backend`.
        """
        paths = (config or {}).get("paths", {})
        folder, bucket = output_dir or paths.get("out_dir"), bucket or paths.get("s3_bucket")
        backends: list[BaseBackend] = []
        if folder and (key_prefix or not bucket):
            backends.append(DiskBackend(folder, overwrite))
        if bucket:
            prefix = key_prefix or (folder and os.fspath(folder))
            backends.append(S3Backend(bucket, prefix, region, endpoint_url, overwrite))
        if not backends:
            raise WriterError("BackendDispatch has nowhere to write: give output_dir, or bucket and key_prefix.")
        super().__init__(backends)

    @staticmethod
    def set_max_queue_size(jobs: int) -> None:
        """How many jobs of all backends may wait before `schedule` blocks."""
        current().io_queue.set_max_queue_size(jobs)


registered: Registry[type[BaseBackend]] = Registry("backend", WriterRegistryError)


def register(backend: type[BaseBackend]) -> None:
    """Make a subclass of BaseBackend available under its class name.

    Raises:
        WriterRegistryError: it is no such class.
    """
    if not isinstance(backend, type) or not issubclass(backend, BaseBackend):
        raise WriterRegistryError(f"{backend!r} is not a subclass of BaseBackend.")
    registered.add(backend.__name__, backend)


def unregister(name: str) -> None:
    """Forget a backend; those that exist go on.

    Raises:
        WriterRegistryError: there is no such backend; the message lists near misses.
    """
    registered.remove(name)


def get(name: str, init_params: Mapping[str, Any] | None = None) -> BaseBackend:
    """A backend by name; without `init_params` it still has to be initialised.

    Raises:
        WriterRegistryError: there is no such backend; the message lists near misses.
        WriterError: it takes no such argument, or needs one that is not there.
    """
    kind = registered.get(name)
    backend = kind.__new__(kind)
    if init_params is not None:
        check_names(name, kind.__init__, init_params)
        backend.initialize(**init_params)
    return backend


def make_backend(
    writer: str,
    output_dir: Any,
    backend: BaseBackend | None,
    *,
    bucket: str | None = None,
    region: str | None = None,
    endpoint_url: str | None = None,
) -> BaseBackend:
    """Where a writer writes: the backend given, the folder, or both; `bucket` takes the folder's place, below
    `output_dir` as a prefix.

    Raises:
        WriterError: none is given, or the backend is none.
    """
    if backend is not None and not isinstance(backend, BaseBackend):
        raise WriterError(
            f"{writer}: backend must be a BaseBackend, such as backends.get('DiskBackend'); got {backend!r}."
        )
    folder = None
    if output_dir or bucket:
        folder = BackendDispatch(output_dir=output_dir, bucket=bucket, region=region, endpoint_url=endpoint_url)
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
