"""Files about the project agree with it: version, extras, templates of issues."""

import re
import tomllib
from pathlib import Path

import pytest
import yaml

import usdsdg

ROOT = Path(__file__).resolve().parents[1]
FIELDS = {"input", "textarea", "dropdown", "checkboxes", "markdown"}


def test_version_and_date_are_the_latest_of_the_changelog_and_those_of_the_citation():
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    versions = re.findall(r"^## (\d+\.\d+\.\d+) \((\d{4}-\d\d-\d\d)\)$", changelog, re.MULTILINE)
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert (citation["version"], str(citation["date-released"])) == versions[0]
    assert usdsdg.__version__ == citation["version"]


def test_the_page_of_installation_lists_every_extra():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    table = [
        line for line in (ROOT / "docs" / "install.md").read_text(encoding="utf-8").splitlines() if line[:3] == "| `"
    ]
    listed = {name for line in table for name in re.findall(r"`(\w+)`", line.split(" | ")[0])}
    assert listed == set(project["optional-dependencies"])


@pytest.mark.parametrize(
    "path", sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml")), ids=lambda path: path.name
)
def test_templates_of_issues_have_what_a_form_needs(path):
    form = yaml.safe_load(path.read_text(encoding="utf-8"))
    if path.name == "config.yml":
        assert isinstance(form["blank_issues_enabled"], bool)
        return
    assert {"name", "description", "body"} <= form.keys()
    ids = [field["id"] for field in form["body"]]
    assert len(set(ids)) == len(ids)
    for field in form["body"]:
        assert field["type"] in FIELDS
        assert field["attributes"]["label"]
