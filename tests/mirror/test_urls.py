"""Single assets at URLs, outside of an assets root: of a web server and of a bucket."""

import json
from pathlib import Path

import pytest
from pxr import Usd

from tests.mirror.server import Server, cut_off
from tests.stores.servers import Bucket, FailingProxy, only_ours
from usdsdg import create
from usdsdg.errors import AssetError, AssetNotFound, Unsupported, UsdsdgWarning
from usdsdg.mirror import download
from usdsdg.mirror.mesh_references import of_mesh
from usdsdg.mirror.root_mirror import RootMirror
from usdsdg.stage import assets

CUP = b"""#usda 1.0
( defaultPrim = "Cup" )
def Cube "Cup" ( references = @../parts/handle%20b.usda@ ) {
    asset picture = @./tex tures/\xc3\xbc.png@
}"""
HANDLE = b'#usda 1.0\n( defaultPrim = "Handle" )\ndef "Handle" {\ndef Sphere "Ball" {\n}\n}'
FILES = {"lab a/cups/c%20p.usda": CUP, "lab a/parts/handle%20b.usda": HANDLE, "lab a/cups/tex tures/ü.png": b"picture"}


@pytest.fixture(autouse=True)
def cache(monkeypatch, tmp_path):
    only_ours(monkeypatch, str(tmp_path / "none"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("USDSDG_FETCH_ASSETS", "1")
    monkeypatch.setattr(download, "_WAIT_SECONDS", 0.01)
    assets.set_mirror_factory(RootMirror)
    yield
    assets.set_mirror_factory(RootMirror)
    assets.set_maps([])


@pytest.fixture
def server():
    running = Server()
    running.files = {f"/{path}": data for path, data in FILES.items()}
    yield running
    running.close()


@pytest.fixture
def bucket(monkeypatch):
    made = Bucket()
    for key, data in FILES.items():
        made.client.put_object(Bucket=made.name, Key=key, Body=data)
    monkeypatch.setenv("AWS_ENDPOINT_URL", made.url)
    return made


def check(local):
    stage = Usd.Stage.Open(local)
    assert stage.GetPrimAtPath("/Cup/Ball").GetTypeName() == "Sphere"
    picture = stage.GetPrimAtPath("/Cup").GetAttribute("picture").Get().resolvedPath
    assert Path(picture).read_bytes() == b"picture"


def test_an_asset_in_a_bucket_comes_once_with_what_it_needs(bucket):
    url = f"s3://{bucket.name}/lab a/cups/c%20p.usda"
    local = assets.resolve(url)
    check(local)
    bucket.client.delete_object(Bucket=bucket.name, Key="lab a/cups/c%20p.usda")
    assets.set_mirror_factory(RootMirror)
    assert assets.resolve(url) == local


def test_an_asset_on_a_web_server_comes_once_with_what_it_needs(server):
    # The path in a web address is encoded; the name of the file is not.
    host = server.url.removesuffix("/Assets/Isaac/4.2")
    url = f"{host}/lab%20a/cups/c%2520p.usda?version=2"
    check(assets.resolve(url))
    check(assets.resolve(url))
    assert max(server.asked.values()) == 1


def test_scripts_reference_urls(bucket, stage):
    item = create.from_usd(f"s3://{bucket.name}/lab a/cups/c%20p.usda")
    (prim,) = item.get_output_prims()["prims"]
    names = [each.GetName() for each in Usd.PrimRange(prim)]
    assert "Ball" in names


def test_a_bucket_as_assets_root(bucket, monkeypatch):
    bucket.client.put_object(Bucket=bucket.name, Key="root x/Isaac/Props/cup.usda", Body=HANDLE)
    assets.set_assets_root(f"s3://{bucket.name}/root x/")
    try:
        assert Path(assets.resolve("/Isaac/Props/cup.usda")).read_bytes() == HANDLE
    finally:
        assets.set_assets_root(None)


def test_a_store_that_comes_back_is_waited_for(bucket, monkeypatch):
    with FailingProxy(bucket.port, lambda number, *_: "drop" if 1 <= number < 30 else "pass") as proxy:
        monkeypatch.setenv("AWS_ENDPOINT_URL", proxy.url)
        with pytest.warns(UsdsdgWarning, match="is asked again for up to 120 s"):
            check(assets.resolve(f"s3://{bucket.name}/lab a/cups/c%20p.usda"))


def test_a_store_that_stays_away_is_an_error(bucket, monkeypatch):
    with FailingProxy(bucket.port) as gone:
        pass
    monkeypatch.setenv("AWS_ENDPOINT_URL", gone.url)
    monkeypatch.setenv("USDSDG_STORE_RETRY_SECONDS", "0")
    with pytest.raises(AssetError, match=r"s3://.*c%20p.usda cannot be read: the server does not answer"):
        assets.resolve(f"s3://{bucket.name}/lab a/cups/c%20p.usda")


@pytest.mark.parametrize(
    ("fate", "kind", "remedy"),
    [
        ("404 NoSuchBucket", AssetError, "no such bucket; make it"),
        ("403 InvalidAccessKeyId", AssetError, "credentials are wrong"),
        ("403 AccessDenied", AssetNotFound, "or denies access"),
        ("404 NoSuchKey", AssetNotFound, "has no x/y.usd"),
    ],
)
def test_what_does_not_pass_is_told_at_once(bucket, monkeypatch, fate, kind, remedy):
    with FailingProxy(bucket.port, lambda *_: fate) as proxy:
        monkeypatch.setenv("AWS_ENDPOINT_URL", proxy.url)
        with pytest.raises(kind, match=remedy):
            assets.resolve(f"s3://{bucket.name}/x/y.usd")
        assert len(proxy.seen) == 1


def test_a_download_that_breaks_off_goes_on(server):
    host = server.url.removesuffix("/Assets/Isaac/4.2")
    server.files["/big.bin"] = bytes(range(256)) * 2000
    server.trouble["/big.bin"] = cut_off(200_000, times=2)
    assert Path(assets.locate(f"{host}/big.bin")).read_bytes() == server.files["/big.bin"]


def test_what_is_not_fetched(server, monkeypatch, tmp_path):
    host = server.url.removesuffix("/Assets/Isaac/4.2")
    for url in (
        f"{host}/../x.usd",
        f"{host}/a//b.usd",
        f"{host}/",
        "omniverse://127.0.0.1/x.usd",
        "ftp://127.0.0.1/x.usd",
    ):
        with pytest.raises((AssetError, Unsupported), match=r"remote|Omniverse"):
            assets.locate(url)
    assets.set_maps([assets.PathMap(host, str(tmp_path))])
    with pytest.raises(Unsupported, match="remote"):
        assets.locate(f"{host}/lab%20a/cups/c%2520p.usda")
    assets.set_maps([])
    monkeypatch.setenv("USDSDG_FETCH_ASSETS", "0")
    with pytest.raises(Unsupported, match="remote"):
        assets.locate(f"{host}/lab%20a/cups/c%2520p.usda")
    assert not server.asked


def test_meshes_come_with_their_materials_and_pictures(server):
    host = server.url.removesuffix("/Assets/Isaac/4.2")
    server.files |= {
        "/m/a.obj": b"mtllib my a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl x\nf 1 2 3\n",
        "/m/my a.mtl": b"newmtl x\nmap_Kd -s 1 1 1 -o 0 0 0 pic ture.png\n",
        "/m/pic ture.png": b"png",
    }
    local = Path(assets.locate(f"{host}/m/a.obj"))
    assert sorted(each.name for each in local.parent.iterdir()) == ["a.obj", "my a.mtl", "pic ture.png"]


@pytest.mark.parametrize(
    ("suffix", "text", "found"),
    [
        (
            ".gltf",
            json.dumps({"buffers": [{"uri": "a%20b.bin"}, {}], "images": [{"uri": "data:x"}, {"uri": "c.png"}]}),
            ["a b.bin", "c.png"],
        ),
        (".gltf", "{", []),
        (".gltf", "[1]", []),
        (
            ".mtl",
            "map_Kd a.png\n  bump -bm 0.2 b c.png\nmap_d -clamp on d.png\nKd 1 1 1",
            ["a.png", "b c.png", "d.png"],
        ),
        (".obj", "v 1 1 1\nmtllib x.mtl", ["x.mtl"]),
    ],
)
def test_references_of_meshes(tmp_path, suffix, text, found):
    file = tmp_path / f"mesh{suffix}"
    file.write_text(text)
    assert list(of_mesh(file, suffix)) == found
