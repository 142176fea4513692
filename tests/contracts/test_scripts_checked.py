"""The totals of docs/scripts_checked.md are those of its table."""

import re
from collections import Counter
from pathlib import Path

PAGE = (Path(__file__).parents[2] / "docs" / "scripts_checked.md").read_text(encoding="utf-8")
STATES = ["unmodified", "with options", "needs edits", "fails"]
OPTIONS = {"--stage", "--map", "--new-stage", "--frames", "--missing-assets", "--assets-root", "--lenient"}


def rows() -> list[list[str]]:
    lines = [line for line in PAGE.splitlines() if line.startswith("| [")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def totals(row: str) -> list[int]:
    (line,) = re.findall(rf"^\| {row} \|(.*)\|$", PAGE, re.MULTILINE)
    return [int(cell) for cell in line.split("|")]


def test_the_totals_are_those_of_the_rows():
    for column, name in ((2, "before"), (3, "now")):
        count = Counter(row[column] for row in rows())
        assert totals(name) == [count[state] for state in STATES]
        assert set(count) <= set(STATES)
    assert PAGE.splitlines()[2].startswith(f"{len(rows())} scripts by ")


def test_each_row_names_a_commit_and_only_options_that_count():
    for repository, script, _, now, options, why in rows():
        assert re.search(r"github\.com/[\w-]+/[\w.-]+/tree/[0-9a-f]{12}\)", repository)
        assert re.fullmatch(r"`.+\.py`", script)
        assert set(re.findall(r"--[a-z-]+", options)) <= OPTIONS
        assert bool(options) == (now == "with options")
        assert why or now in ("unmodified", "with options")
