"""A Ceph cluster of one monitor, one store in memory and one S3 gateway, in a temporary folder on this machine."""

from __future__ import annotations

import shutil
import signal
import subprocess
import tempfile
import time
import urllib.error
import urllib.request
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.stores.servers import KEYS

PROGRAMS = ("ceph", "ceph-mon", "ceph-osd", "ceph-authtool", "monmaptool", "radosgw", "radosgw-admin")
PACKAGES = "ceph-mon ceph-osd ceph-common radosgw"  # of Debian
PORT = 37580
_MONITORS = "[v2:127.0.0.1:33400,v1:127.0.0.1:33889]"
_CONFIG = """[global]
fsid = {fsid}
auth cluster required = cephx
auth service required = cephx
auth client required = cephx
mon host = {monitors}
mon initial members = a
osd pool default size = 1
osd pool default min size = 1
osd pool default pg num = 1
osd crush chooseleaf type = 0
osd crush update on start = false
osd objectstore = memstore
memstore device bytes = 2147483648
osd class dir = {classes}
mon allow pool size one = true
mon data avail crit = 1
mon data = {folder}/mon
osd data = {folder}/osd
run dir = {folder}
log file = {folder}/$name.log
admin socket = {folder}/$name.$pid.asok
pid file = {folder}/$name.pid
public addr = 127.0.0.1
cluster addr = 127.0.0.1
keyring = {folder}/keyring
rgw frontends = beast endpoint=127.0.0.1:{port}
"""


def is_installed() -> bool:
    """Whether all programs that it takes are there."""
    return all(shutil.which(each) for each in PROGRAMS)


@contextmanager
def running() -> Iterator[int]:
    """Run the cluster with the tests' keys; yield the port of its gateway."""
    folder = Path(tempfile.mkdtemp(prefix="ceph-"))
    daemons: list[subprocess.Popen[bytes]] = []
    classes = next(Path("/usr/lib").glob("*/rados-classes"), folder)
    fsid = str(uuid.uuid4())
    text = _CONFIG.format(fsid=fsid, monitors=_MONITORS, classes=classes, folder=folder, port=PORT)
    (folder / "ceph.conf").write_text(text)
    for name in ("mon", "osd"):
        (folder / name).mkdir()
    keyring, osd_keyring, own = str(folder / "keyring"), str(folder / "osd.keyring"), ("-c", str(folder / "ceph.conf"))
    everything = ("--cap", "mon", "allow *", "--cap", "osd", "allow *", "--cap", "mgr", "allow *")

    def call(*command: str) -> bytes:
        done = subprocess.run(command, capture_output=True, timeout=120, check=False)
        assert done.returncode == 0, f"{command}: {done.stderr.decode()}"
        return done.stdout

    def start(*command: str) -> None:
        with (folder / f"{command[0]}.out").open("wb") as out:
            daemons.append(subprocess.Popen([*command, "-f"], stdout=out, stderr=out))

    try:
        call("ceph-authtool", "--create-keyring", keyring, "--gen-key", "-n", "mon.", "--cap", "mon", "allow *")
        call("ceph-authtool", keyring, "--gen-key", "-n", "client.admin", *everything)
        call("monmaptool", "--create", "--fsid", fsid, "--addv", "a", _MONITORS, str(folder / "map"))
        call("ceph-mon", *own, "--mkfs", "-i", "a", "--monmap", str(folder / "map"), "--keyring", keyring)
        start("ceph-mon", *own, "-i", "a")
        disk = str(uuid.uuid4())
        call("ceph", *own, "osd", "new", disk)
        key = call("ceph", *own, "auth", "get-or-create", "osd.0", "mon", "allow profile osd", "osd", "allow *")
        Path(osd_keyring).write_bytes(key)
        call("ceph-osd", *own, "-i", "0", "--mkfs", "--osd-uuid", disk, "--keyring", osd_keyring)
        call("ceph", *own, "osd", "crush", "add", "osd.0", "1", "root=default", "host=here")
        start("ceph-osd", *own, "-i", "0", "--keyring", osd_keyring)
        start("radosgw", *own, "-n", "client.admin", "--keyring", keyring)
        keys = (f"--access-key={KEYS['AWS_ACCESS_KEY_ID']}", f"--secret-key={KEYS['AWS_SECRET_ACCESS_KEY']}")
        call("radosgw-admin", *own, "user", "create", "--uid=tests", "--display-name=tests", *keys)
        _wait_for(PORT)
        yield PORT
    finally:
        for each in reversed(daemons):
            each.send_signal(signal.SIGKILL)
            each.wait()
        shutil.rmtree(folder, ignore_errors=True)


def _wait_for(port: int) -> None:
    for _ in range(240):
        try:
            urllib.request.urlopen(f"http://127.0.0.1:{port}/", timeout=5).close()
            return
        except (urllib.error.URLError, OSError):
            time.sleep(0.5)
    raise AssertionError("the gateway of Ceph did not start")
