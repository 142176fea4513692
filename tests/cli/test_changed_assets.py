"""A run that is resumed tells of assets that were changed since its first frames."""

import pytest

from tests import forked

BOX = '#usda 1.0\n(\n    defaultPrim = "Box"\n)\ndef Cube "Box"\n{{\n    double size = {size}\n}}\n'
SCRIPT = """
import sys
import omni.replicator.core as rep
from isaacsim.storage.native import get_assets_root_path
rep.create.light(light_type="Dome")
box = rep.create.from_usd(get_assets_root_path() + "/Isaac/box.usda", semantics=[("class", "box")])
with rep.trigger.on_frame(), box:
    rep.modify.pose(position=rep.distribution.uniform((-1, -1, -1), (1, 1, 1)))
product = rep.create.render_product(rep.create.camera(position=(5, 0, 2), look_at=(0, 0, 0)), (32, 24))
writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir=sys.argv[1], rgb=True)
writer.attach(product)
"""
SAID = "the asset /Isaac/box.usda has other content than when earlier frames were made"


@pytest.mark.parametrize("size", [1.0, 2.0])
def test_frames_that_are_added_after_an_asset_was_changed_are_named(size, tmp_path):
    asset = tmp_path / "assets/Isaac/box.usda"
    asset.parent.mkdir(parents=True)
    asset.write_text(BOX.format(size=1.0))
    (tmp_path / "script.py").write_text(SCRIPT)
    first = _run(tmp_path, "--frames", "2")
    asset.write_text(BOX.format(size=size))
    more = _run(tmp_path, "--frames", "4", "--resume")
    assert SAID not in first.stderr
    assert (SAID in more.stderr) == (size != 1.0)
    assert more.stderr.count(SAID) <= 1
    assert len(list((tmp_path / "data").glob("rgb_*.png"))) == 5  # 0 to 4


def _run(folder, *options):
    command = ["-m", "usdsdg", "run", "-q", "--device", "cpu", "--assets-root", str(folder / "assets"), *options]
    done = forked.run([*command, "script.py", str(folder / "data")], cwd=folder)
    assert done.returncode == 0, done.stderr
    return done
