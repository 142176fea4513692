"""The assets of a dataset are held against the files that are on this machine when it is verified."""

import hashlib
import json

import pytest

from usdsdg.verify.recorded_assets import RecordedAssets
from usdsdg.writers.journal import recipe


@pytest.mark.usefixtures("stage")
def test_an_asset_that_changes_between_two_verifications_is_named_by_the_second(tmp_path, monkeypatch):
    monkeypatch.setenv("USDSDG_ASSETS_ROOT", str(tmp_path / "root"))
    (tmp_path / "root").mkdir()
    asset, dataset = tmp_path / "root/a.usda", tmp_path / "dataset"
    asset.write_text("#usda 1.0\n")
    listed = [{"name": "/a.usda", "sha256": hashlib.sha256(asset.read_bytes()).hexdigest()}]
    (dataset / recipe.FILE).parent.mkdir(parents=True)
    (dataset / recipe.FILE).write_text(json.dumps({"format": recipe.FORMAT, "assets": listed}))
    assert RecordedAssets(dataset).changed() == []
    asset.write_text("#usda 1.0\n\n")
    assert RecordedAssets(dataset).changed() == ["/a.usda"]
