"""The recording of a whole job, `--rerun`: one file, or the viewer, beside the job's own writers."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

from usdsdg.errors import OutputNotWritable, Unsupported
from usdsdg.operating_system import process_name
from usdsdg.session.render_products import products
from usdsdg.writers.base import attached_writers
from usdsdg.writers.formats.rerun.rerun_chunks import APPLICATION
from usdsdg.writers.formats.rerun.rerun_extra import rerun
from usdsdg.writers.formats.rerun.writer_rerun import RerunWriter, recording_id

VIEWER, SUFFIX = "viewer", ".rrd"
_LOOPBACK = "127.0.0.1"
_DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY")


class JobRecording:
    """Records every captured frame of the render products that writers are attached to."""

    def __init__(self, target: str) -> None:
        """target: a path that ends in .rrd, or "viewer".

        Raises:
            Unsupported: Rerun is not installed, there is no display for the viewer, or the path has another ending.
            OutputNotWritable: the file cannot be written.
        """
        self._file: Path | None = None
        self._stream: Any = None
        if target == VIEWER:
            _check_display()
        elif not target.lower().endswith(SUFFIX):
            raise Unsupported(f"--rerun {target}: a recording is a file that ends in {SUFFIX}, such as run{SUFFIX}")
        else:
            self._file = _writable(Path(target).absolute())
        self._writer = RerunWriter(sink=self)

    def follow(self) -> None:
        """Attach to the render products of writers, of all if no writer is attached; called before each frame."""
        others = [writer for writer in attached_writers() if writer is not self._writer]
        wanted = {path for writer in others for path in writer.render_products}
        paths = [each.path for each in products() if each.tiles is None and (each.path in wanted or not others)]
        if tuple(paths) == self._writer.render_products:
            return
        self._writer.detach()
        if paths:
            self._writer.attach(paths)

    def send(self, made: list[Any]) -> None:
        """Add the chunks of a frame."""
        rr = rerun()
        if self._stream is None:
            self._stream = rr.RecordingStream(APPLICATION, recording_id=recording_id(""), send_properties=False)
            if self._file is None:
                self._stream.connect_grpc(_started_viewer())
            else:
                self._stream.save(_unfinished(self._file))
        rr.send_chunks(made, recording=self._stream)

    def close(self) -> Path | None:
        """End the recording; return its file, which has appeared now, or None where there is none."""
        self._writer.detach()
        if self._stream is None:
            return None
        self._stream.flush()
        self._stream.disconnect()
        self._stream = None
        if self._file is not None:
            _unfinished(self._file).replace(self._file)
        return self._file


def _unfinished(file: Path) -> Path:
    return file.with_name(f".{file.stem}.{process_name()}{SUFFIX}")


def _writable(file: Path) -> Path:
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        _unfinished(file).touch()
        _unfinished(file).unlink()
    except OSError as error:
        raise OutputNotWritable(f"--rerun {file}: {error.strerror}. Choose another path.") from error
    return file


def _started_viewer() -> str:
    """Start a viewer that goes on after this process, and return its address, which only this machine reaches.

    `RecordingStream.spawn` would let all of the network in.
    """
    with socket.socket() as free:
        free.bind((_LOOPBACK, 0))
        port = free.getsockname()[1]
    command = [sys.executable, "-m", "rerun", "--bind", _LOOPBACK, "--port", str(port)]
    nothing = subprocess.DEVNULL
    subprocess.Popen(command, start_new_session=True, stdin=nothing, stdout=nothing, stderr=nothing)
    return f"rerun+http://{_LOOPBACK}:{port}/proxy"


def _check_display() -> None:
    if sys.platform.startswith("linux") and not any(os.environ.get(name) for name in _DISPLAYS):
        raise Unsupported(f"--rerun: there is no display for the viewer. Give a file, as --rerun run{SUFFIX}")
