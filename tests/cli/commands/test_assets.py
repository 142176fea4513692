"""`usdsdg assets get | list | check`, and a script whose assets root is a URL, against a server on the loopback."""

from pathlib import Path

import pytest

from tests.mirror.server import Server
from tests.scripts.conftest import usdsdg

CUP = "Isaac/Props/cup.usda"


@pytest.fixture
def server(tmp_path, monkeypatch):
    pytest.importorskip("obstore", reason="needs the remote extra")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    server = Server()
    server.files[CUP] = b'#usda 1.0\n( defaultPrim = "Cup" )\ndef Cube "Cup" {\nasset picture = @./cup.png@\n}'
    server.files["Isaac/Props/cup.png"] = b"cup"
    server.files["Isaac/Props/saucer.usda"] = (
        b'#usda 1.0\n( defaultPrim = "S" )\ndef "S" ( references = @cup.usda@ ) {}'
    )
    yield server
    server.close()


def test_files_are_copied_listed_checked_and_repaired(server, tmp_path):
    got = usdsdg("assets", "get", f"/{CUP}", "--assets-root", server.url, "--quiet", cwd=tmp_path)
    file = Path(got.stdout.strip())
    assert file.read_bytes() == server.files[CUP]
    listed = usdsdg("assets", "list", "--assets-root", server.url, cwd=tmp_path).stdout.splitlines()
    assert [line.split()[-1] for line in listed[:-1]] == ["Isaac/Props/cup.png", CUP]
    assert listed[-1].startswith(f"2 files of {server.url}")
    file.chmod(0o644)
    file.write_bytes(b"spoiled")
    bad = usdsdg("assets", "check", "--assets-root", server.url, cwd=tmp_path, expect=1)
    assert f"{CUP}: cut off" in bad.stderr
    assert "2 files, 1 damaged" in bad.stdout
    usdsdg("assets", "check", "--repair", "--assets-root", server.url, "--quiet", cwd=tmp_path)
    assert "2 files, 0 damaged" in usdsdg("assets", "check", "--assets-root", server.url, cwd=tmp_path).stdout
    assert file.read_bytes() == server.files[CUP]


def test_a_file_that_the_root_lacks_and_a_root_that_is_a_folder_are_errors(server, tmp_path):
    gone = usdsdg("assets", "get", "/Isaac/gone.usd", "--assets-root", server.url, cwd=tmp_path, expect=1)
    assert f"{server.url} has no Isaac/gone.usd" in gone.stderr
    folder = usdsdg("assets", "list", "--assets-root", str(tmp_path), cwd=tmp_path, expect=1)
    assert "is a folder" in folder.stderr


def test_a_script_references_what_is_on_the_server(server, tmp_path):
    (tmp_path / "script.py").write_text("""
import omni.usd
from isaacsim.storage.native import get_assets_root_path
from isaacsim.core.utils.stage import add_reference_to_stage
stage = omni.usd.get_context().get_stage()
root = get_assets_root_path()
one = add_reference_to_stage(root + "/Isaac/Props/cup.usda", "/World/One")
two = stage.DefinePrim("/World/Two")
two.GetReferences().AddReference(root + "/Isaac/Props/saucer.usda")
print(one.GetTypeName(), two.GetTypeName())
""")
    done = usdsdg("run", "--quiet", "--assets-root", server.url, "script.py", cwd=tmp_path)
    assert done.stdout.split() == ["Xform", "Cube"]


def test_single_urls_are_copied_without_a_root(server, tmp_path, monkeypatch):
    monkeypatch.setenv("USDSDG_FETCH_ASSETS", "1")
    server.files["/lab/saucer x.usda"] = server.files["Isaac/Props/saucer.usda"]
    host = server.url.removesuffix("/Assets/Isaac/4.2")
    got = usdsdg("assets", "get", f"{host}/lab/saucer%20x.usda", "--quiet", cwd=tmp_path)
    assert Path(got.stdout.strip()).read_bytes() == server.files["/lab/saucer x.usda"]
