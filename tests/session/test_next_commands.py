"""Which commands are named at the end of a run."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

import usdsdg as rep
from usdsdg.session import next_commands
from usdsdg.session.next_commands import next_commands as commands
from usdsdg.writers.formats.writer_basic import BasicWriter


class OwnWriter(rep.Writer):
    """Of a format that nothing reads back."""

    def write(self, data):
        """Write nothing."""


class OwnBasicWriter(BasicWriter):
    """Of BasicWriter's format."""


@pytest.mark.parametrize(
    ("writers", "portion", "expected"),
    [
        ([BasicWriter], None, ["inspect", "verify"]),
        ([OwnBasicWriter], None, ["inspect", "verify"]),
        ([], None, ["inspect", "verify"]),
        ([OwnWriter], None, ["verify"]),
        ([BasicWriter, OwnWriter], None, ["inspect", "verify"]),
        ([BasicWriter], "0/2", ["merge"]),
    ],
)
def test_only_commands_are_named_that_can_look_at_what_was_written(monkeypatch, tmp_path, writers, portion, expected):
    run = SimpleNamespace(portion=portion)
    session = SimpleNamespace(run=run, writers_kinds={str(tmp_path): set(writers)} if writers else {})
    monkeypatch.setattr(next_commands, "current", lambda: session)
    assert [line.partition("usdsdg ")[2].split()[0] for line in commands([tmp_path])] == expected


def test_each_folder_has_the_commands_that_can_look_at_it(monkeypatch, tmp_path):
    kinds = {str(tmp_path / "own"): {OwnWriter}, str(tmp_path / "all/basic"): {BasicWriter}}
    session = SimpleNamespace(run=SimpleNamespace(portion=None), writers_kinds=kinds)
    monkeypatch.setattr(next_commands, "current", lambda: session)
    found = [line.partition("usdsdg ")[2].split()[:2] for line in commands([tmp_path / "own", tmp_path / "all"])]
    assert found == [
        ["verify", str(tmp_path / "own")],
        ["inspect", str(tmp_path / "all")],
        ["verify", str(tmp_path / "all")],
    ]


PROGRAM = """
import os
import usdsdg as rep

os.makedirs("work/other")
os.chdir("work")

class OwnWriter(rep.Writer):
    def __init__(self, output_dir):
        self.backend = rep.backends.DiskBackend(output_dir)
        self.annotators = ["rgb"]

    def write(self, data):
        self.backend.write_blob("a.txt", b"a")

product = rep.create.render_product(rep.create.camera(), (8, 8))
rep.writers.register_writer(OwnWriter)
for name, options in (("OwnWriter", {}), ("BasicWriter", {"distance_to_camera": True})):
    writer = rep.writers.get(name)
    writer.initialize(output_dir=os.path.abspath(name), **options)
    writer.attach(product)
rep.orchestrator.step()
rep.orchestrator.wait_until_complete()
for writer in list(rep.writers.attached_writers()):
    writer.detach()
"""


def test_paths_are_those_of_where_the_program_was_started(tmp_path):
    (tmp_path / "program.py").write_text(PROGRAM)
    done = subprocess.run(
        [sys.executable, "program.py"], cwd=tmp_path, capture_output=True, text=True, timeout=300,
        env={**os.environ, "PYTHONPATH": str(Path(rep.__file__).parents[1])},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    named = re.findall(r"usdsdg (\w+) (\S+)", done.stderr)
    own, basic = (os.path.join("work", name) for name in ("OwnWriter", "BasicWriter"))
    assert sorted(named) == [("inspect", basic), ("verify", basic), ("verify", own)]


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash")
@pytest.mark.parametrize("name", [b"a\nb", b"o\xff", "\u00e9'\\\xff".encode() + b"\xff7", b"two words"])
def test_odd_names_of_folders_are_quoted_so_that_bash_has_them_again(name, monkeypatch, tmp_path):
    monkeypatch.setattr(sys.modules["usdsdg"], "_STARTED_IN", str(tmp_path))
    monkeypatch.setattr(
        next_commands, "current", lambda: SimpleNamespace(run=SimpleNamespace(portion=None), writers_kinds={})
    )
    (line, *_) = commands([tmp_path / os.fsdecode(name)])
    assert line.isprintable()
    command = line.split("usdsdg inspect ")[1].rsplit("   (", 1)[0]
    assert subprocess.run(["bash", "-c", f"printf %s {command}"], capture_output=True).stdout == name
