"""Which URLs of a script are sure to be needed, by its text alone."""

import ast

import pytest

from usdsdg.cli.script.literal_assets import literal_assets

GONE = "omniverse://localhost/Projects/gone.usd"


def found(text: str) -> list[tuple[str, int]]:
    return [(each.url, each.line) for each in literal_assets(ast.parse(text))]


@pytest.mark.parametrize(
    "url",
    [
        GONE, "https://server/a/b.usd?version=2", "s3://bucket/a.png", "C:/assets/a.usd", "C:\\assets\\a.usdz",
        "/Isaac/Props/a.usd", "/NVIDIA/Assets/Skies/a.hdr",
    ],
)  # fmt: skip
def test_urls_that_end_like_assets_are_found_with_their_line(url):
    assert found(f"import x\ndef make():\n    x.create({url!r})\nmake()") == [(url, 3)]


def test_a_url_below_a_root_is_found_in_a_sum_and_in_a_formatted_string():
    assert found("root + '/Isaac/a.usd'") == [("/Isaac/a.usd", 1)]
    assert found("f'{root}/Isaac/a.usd'") == [("/Isaac/a.usd", 1)]


@pytest.mark.parametrize(
    "text",
    [
        "f'{root}/Isaac/Props/{name}.usd'",
        "'omniverse://localhost/Projects'",
        "'picture.png'",
        "'/home/me/picture.png'",
        "'OmniPBR.mdl'",
        "'see https://host/manual.usd for more,\\nand others'",
        f"if a: open_stage({GONE!r})",
        f"a = b or {GONE!r}",
        f"try:\n    open_stage({GONE!r})\nexcept Exception: pass",
        f"config = {{'env': {GONE!r}}}",
        f"parser.add_argument('--env', default={GONE!r})",
        f"def make(env={GONE!r}): pass",
        f"stage.Export({GONE!r})",
        f"name.startswith({GONE!r})",
    ],
)  # fmt: skip
def test_what_may_not_be_read_is_not_found(text):
    assert found(text) == []


def test_each_url_is_found_once():
    assert found(f"a = {GONE!r}\nb = {GONE!r}") == [(GONE, 1)]


def test_a_picture_of_the_viewport_is_no_asset():
    text = 'capture_viewport_to_file(view, "K:/temp/a.png")\nopen_stage("K:/temp/a.usd")\n'
    assert [each.url for each in literal_assets(ast.parse(text))] == ["K:/temp/a.usd"]
