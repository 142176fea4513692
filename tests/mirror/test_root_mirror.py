"""Mirrors of an assets root on a real HTTP server, also one that drops connections, cuts off and redirects."""

import multiprocessing
import os
import random
from pathlib import Path

import pytest
from pxr import Usd, UsdGeom

from tests.mirror.server import Handler, Server, cut_off
from usdsdg.errors import AssetError, AssetNotFound, AssetUnreadable, Unsupported
from usdsdg.mirror import download
from usdsdg.mirror.root_mirror import RootMirror
from usdsdg.stage import assets

ROOM = "Isaac/Environments/room.usda"
PROP = "Isaac/Props/cup/cup.usda"


@pytest.fixture
def server(tmp_path, monkeypatch):
    """A server with a room that needs a prop, its texture and its material; the cache is the test's own."""
    pytest.importorskip("obstore", reason="needs the remote extra")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(download, "_WAIT_SECONDS", 0.001)
    monkeypatch.setattr("usdsdg.mirror.store.RETRIES", 0)
    monkeypatch.setenv("USDSDG_STORE_RETRY_SECONDS", "0")
    server = Server()
    server.files = {
        ROOM: b"""#usda 1.0
            ( defaultPrim = "Room"
              subLayers = [@./lights.usda@] )
            def "Room" {
                def "Cup" ( payload = @../Props/cup/cup.usda@ ) {}
                def "Lost" ( references = @./gone.usda@ ) {}
            }""",
        "Isaac/Environments/lights.usda": b'#usda 1.0\ndef DomeLight "Sky" {\nasset inputs:texture:file = @sky.hdr@\n}',
        "Isaac/Environments/sky.hdr": b"#?RADIANCE sky",
        PROP: b"""#usda 1.0
            ( defaultPrim = "Cup" )
            def Cube "Cup" (
                variants = { string color = "red" }
                prepend variantSets = "color"
            ) {
                asset tiles = @./textures/tile.<UDIM>.png@
                variantSet "color" = {
                    "red" {
                        asset look = @Materials/Red.mdl@
                    }
                    "blue" {
                        asset picture = @textures/blue.png@
                    }
                }
            }""",
        "Isaac/Props/cup/Materials/Red.mdl": b'mdl 1.6;\nimport ::OmniPBR::OmniPBR;\nusing .::Base import *;\n'
        b'export material Red(*) = OmniPBR(diffuse_texture: texture_2d("./red.png", ::tex::gamma_srgb));',
        "Isaac/Props/cup/Materials/Base.mdl": b"mdl 1.6;",
        "Isaac/Props/cup/Materials/red.png": b"red",
        "Isaac/Props/cup/textures/blue.png": b"blue",
        "Isaac/Props/cup/textures/tile.1001.png": b"tile",
        "Isaac/Props/cup/textures/tile.1012.png": b"other tile",
    }  # fmt: skip
    yield server
    server.close()
    assets.set_assets_root(None)


def there(mirror: RootMirror) -> set[str]:
    folder = Path(mirror.folder)
    return {file.relative_to(folder).as_posix() for file in folder.rglob("*") if file.is_file()}


def test_a_stage_comes_with_all_that_it_needs(server):
    mirror = RootMirror(server.url)
    assert mirror.fetch(ROOM)
    assert there(mirror) == set(server.files)
    assert all((Path(mirror.folder) / name).read_bytes() == data for name, data in server.files.items())
    stage = Usd.Stage.Open(f"{mirror.folder}/{ROOM}")
    assert UsdGeom.Cube(stage.GetPrimAtPath("/Room/Cup"))
    assert max(server.asked.values()) == 1


def test_what_has_come_is_read_without_the_server(server):
    RootMirror(server.url).fetch(PROP)
    server.close()
    mirror = RootMirror(server.url)
    assert mirror.fetch(PROP)
    assert mirror.damaged() == []


def test_only_what_is_asked_for_comes(server):
    mirror = RootMirror(server.url)
    assert mirror.fetch("Isaac/Environments/lights.usda")
    assert there(mirror) == {"Isaac/Environments/lights.usda", "Isaac/Environments/sky.hdr"}
    assert not mirror.fetch("Isaac/Environments/gone.usda")
    assert not mirror.fetch("Isaac/Environments")
    assert server.asked["Isaac/Environments"] == 0


def test_files_with_the_same_content_are_kept_once(server):
    server.files["Isaac/copy.hdr"] = server.files["Isaac/Environments/sky.hdr"]
    mirror = RootMirror(server.url)
    for name in ("Isaac/copy.hdr", "Isaac/Environments/sky.hdr"):
        assert mirror.fetch(name)
    one, other = (os.stat(Path(mirror.folder) / name) for name in ("Isaac/copy.hdr", "Isaac/Environments/sky.hdr"))
    assert one.st_ino == other.st_ino


def test_urls_and_paths_below_the_root_are_looked_up_in_the_mirror(server):
    assets.set_assets_root(server.url)
    folder = assets.assets_root()
    for url in (f"/{PROP}", f"{server.url}/{PROP}", f"omniverse://localhost/{PROP}", f"{folder}/{PROP}"):
        assert assets.resolve(url) == f"{folder}/{PROP}"
    with pytest.raises(AssetNotFound, match=rf"{server.url} has no Isaac/gone\.usd"):
        assets.resolve("/Isaac/gone.usd")


# --- servers that misbehave ---
BIG = "Isaac/big.bin"


@pytest.fixture
def big(server):
    server.files[BIG] = random.Random(1).randbytes(600_000)
    return server.files[BIG]


def content(mirror: RootMirror, name: str = BIG) -> bytes:
    return (Path(mirror.folder) / name).read_bytes()


def test_a_dropped_connection_goes_on_where_it_ended(server, big):
    server.trouble[BIG] = cut_off(250_000, times=2)
    mirror = RootMirror(server.url)
    assert mirror.fetch(BIG)
    assert content(mirror) == big
    assert server.ranges
    assert server.sent[BIG] < len(big) + 2 * 2**16  # of a cut, at most one chunk came twice


def test_a_download_goes_on_in_the_next_process(server, big):
    def refuse(handler: Handler, data: bytes) -> None:
        if handler.headers.get("Range"):
            handler.close_connection = True
        else:
            handler.give(data, upto=400_000)

    server.trouble[BIG] = refuse
    with pytest.raises(AssetError, match=r"ended too early|cannot be read"):
        RootMirror(server.url).fetch(BIG)
    del server.trouble[BIG]
    before = server.sent[BIG]
    mirror = RootMirror(server.url)
    assert mirror.fetch(BIG)
    assert content(mirror) == big
    assert server.sent[BIG] - before < 400_000


def test_a_file_that_changed_in_between_comes_anew(server, big):
    def change(handler: Handler, data: bytes) -> None:
        handler.give(data, upto=300_000)
        server.files[BIG] = data[::-1]
        del server.trouble[BIG]

    server.trouble[BIG] = change
    mirror = RootMirror(server.url)
    assert mirror.fetch(BIG)
    assert content(mirror) == big[::-1]


@pytest.mark.parametrize("etags", [True, False])
def test_a_server_without_ranges_sends_the_file_again(server, big, etags):
    server.gives_etags = etags
    left = [1]

    def answer(handler: Handler, data: bytes) -> None:
        left[0] -= 1
        handler.give(data, upto=100_000 if left[0] == 0 else None, ranges=False)

    server.trouble[BIG] = answer
    mirror = RootMirror(server.url)
    assert mirror.fetch(BIG)
    assert content(mirror) == big


def test_a_server_that_always_cuts_off_is_an_error_and_leaves_no_file(server, big):
    server.gives_etags = False
    server.trouble[BIG] = lambda handler, data: handler.give(data, upto=1000, ranges=False)
    mirror = RootMirror(server.url)
    with pytest.raises(AssetError, match=rf"{BIG} ended too early"):
        mirror.fetch(BIG)
    assert there(mirror) == set()


def test_redirects_are_followed(server, big):
    def move(handler: Handler, data: bytes) -> None:
        handler.send_response(302)
        handler.send_header("Location", "/Assets/Isaac/4.2/Isaac/moved.bin")
        handler.send_header("Content-Length", "0")
        handler.end_headers()

    server.files["Isaac/moved.bin"] = big
    server.trouble[BIG] = move
    mirror = RootMirror(server.url)
    assert mirror.fetch(BIG)
    assert content(mirror) == big


@pytest.mark.parametrize(("code", "there"), [(404, False), (403, False), (410, None), (500, None)])
def test_answers_without_a_file(server, big, code, there, monkeypatch):
    monkeypatch.setattr(download, "ATTEMPTS", 2)
    server.trouble[BIG] = lambda handler, data: handler.send_error(code)
    if there is None:
        with pytest.raises(AssetError, match=str(code)):
            RootMirror(server.url).fetch(BIG)
    else:
        assert RootMirror(server.url).fetch(BIG) is there


def test_a_page_in_place_of_a_stage_is_an_error(server):
    server.files["Isaac/page.usd"] = b"<!DOCTYPE html><title>Log in</title>"
    with pytest.raises(AssetUnreadable, match="no USD file"):
        RootMirror(server.url).fetch("Isaac/page.usd")


def test_no_server_is_an_error_that_names_the_url(server, monkeypatch):
    server.close()
    with pytest.raises(AssetError, match=server.url):
        RootMirror(server.url).fetch(PROP)


def test_damage_is_found_and_mended(server):
    mirror = RootMirror(server.url)
    mirror.fetch(PROP)
    for name, spoil in (("cup.usda", b"x"), ("Materials/red.png", b"rat")):
        file = Path(mirror.folder) / "Isaac/Props/cup" / name
        file.chmod(0o644)
        file.write_bytes(spoil)
    damaged = {record.path.rsplit("/", 1)[1]: (record, why) for record, why in mirror.damaged()}
    assert {name: why for name, (_, why) in damaged.items()} == {
        "cup.usda": f"cut off: 1 of {len(server.files[PROP])} bytes",
        "red.png": "other bytes",
    }
    for record, _ in damaged.values():
        mirror.drop(record)
    assert mirror.fetch(PROP)
    mirror.fetch("Isaac/Props/cup/Materials/red.png")
    assert mirror.damaged() == []


def _fetch(url: str) -> bool:
    return RootMirror(url).fetch(ROOM)


def test_processes_share_one_download(server):
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        assert pool.map(_fetch, [server.url] * 2) == [True, True]
    assert all(server.asked[name] == 1 for name in server.files)
    assert there(RootMirror(server.url)) == set(server.files)


def test_other_urls_are_not_mirrored(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    with pytest.raises(Unsupported, match="expected a folder or a URL of http"):
        RootMirror("omniverse://localhost/NVIDIA")
