"""Code in the documentation: each block is run somewhere, is a command line that is parsed here, or says why not."""

import re
import shlex
from importlib.util import find_spec

import click
import pytest

import usdsdg as rep
from tests.site.test_walks import PAGES as WALKED
from tests.site.walk import ROOT, Block, blocks
from usdsdg.cli.app import app
from usdsdg.cli.options.optional_values import completed

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
# Its commands are wrong on purpose, and a test of their own makes them.
MISTAKES = ROOT / "docs/mistakes.md"
READ = [page for page in PAGES if page not in (*WALKED, MISTAKES)]
# What stands before a command, and ends it.
BEFORE = re.compile(r"^(exec |\w+=\S+ |\w+=\$\(\(.*?\)\); )+")
ARITHMETIC = re.compile(r"\$\(\(.*?\)\)|\$\w+")


def commands(block: Block) -> list[list[str]]:
    """Return the arguments of each command of a block; comments and what the shell would insert are left out."""
    lines = ARITHMETIC.sub("1", block.code.replace("\\\n", " ")).splitlines()
    found = [shlex.split(BEFORE.sub("", line), comments=True) for line in lines]
    return [words for words in found if words]


@pytest.mark.parametrize("page", READ, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_command_lines_are_ones_that_the_program_takes(page):
    for block in blocks(page):
        if block.language != "bash" or block.reason:
            continue
        for words in commands(block):
            where = f"{page.name}:{block.line}: {' '.join(words)}"
            if words[:2] == ["python", "-m"]:
                assert find_spec(words[2]), where
                continue
            assert words[0] == "usdsdg", f"{where}: say why it is not run: <!-- not run: REASON -->"
            name, *arguments = completed(words[1:])
            command = app.commands[name]
            if isinstance(command, click.Group):
                name, *arguments = arguments
                command = command.commands[name]
            options = {each for parameter in command.params for each in parameter.opts}
            given = {word.partition("=")[0] for word in arguments if word.startswith("--") and word != "--"}
            assert given <= options or name == "run", f"{where}: no option {given - options}"
            if name == "run":
                context = command.make_context(name, [*arguments], resilient_parsing=True)
                of_script = options & set(context.params["arguments"]) - {"--assets-root", "--save-stage"}
                assert not of_script, f"{where}: the script would get {of_script}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_commands_stand_in_blocks_of_a_language(page):
    """A block without a language, or indented lines, would be looked at by no test."""
    text = page.read_text(encoding="utf-8")
    if page not in (MISTAKES, ROOT / "README.md"):
        outside = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
        assert not re.findall(r"^    (?:usdsdg|python|pip) .*$", outside, re.MULTILINE)
        assert not [
            each for each in blocks(page) if not each.language and re.match(r"\$? ?(usdsdg|python) ", each.code)
        ]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_rows_of_tables_stand_under_a_head_of_as_many_columns(page):
    """Others are shown as text with bars, as rows after an empty line are."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    for table in re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE):
        columns = [len(re.split(r"(?<!\\)\|", row)) for row in table.splitlines()]
        assert len(set(columns)) == 1, table
        assert re.fullmatch(r"\|(?: ?:?-+:? ?\|)+", table.splitlines()[1]), table


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_and_pictures_are_files_of_the_repository(page):
    """For those who read the pages there; the test of the site looks at what the site makes of them."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    targets = [target.partition("#")[0] for target in re.findall(r"\]\(([^)\s]+)\)", text)]
    assert not [each for each in targets if "://" not in each and not (page.parent / each).exists()]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_names_of_replicator_that_pages_mention_exist(page):
    """Names in tables and text, such as those of the tables for other tools; code is run by other tests."""
    text = page.read_text(encoding="utf-8")
    for name in re.findall(r"`rep\.([a-zA-Z_][\w.]*)", text):
        value = rep
        for part in name.rstrip(".").split("."):
            assert hasattr(value, part), f"rep.{name}"
            value = getattr(value, part)
    for name in re.findall(r"`(\w+Writer)`", text):
        assert name in rep.writers.get_writers() or hasattr(rep, name), name
