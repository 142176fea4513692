"""Scripts of Isaac Sim 4.5 import what later versions have too, and read colors as packed ones."""

import ast

import pytest

from tests.scripts.conftest import usdsdg
from usdsdg.cli.script.packed_colors import reads_packed_colors

SCRIPT = """
import numpy as np
from isaacsim import SimulationApp
app = SimulationApp()
import omni.replicator.core as rep
from isaacsim.core.utils.semantics import add_update_semantics
rep.create.cube(semantics=[("class", "cube")])
mask = rep.annotators.get("semantic_segmentation", init_params={"colorize": True})
mask.attach(rep.create.render_product(rep.create.camera(position=(0, -5, 1), look_at=(0, 0, 0)), (16, 12)))
rep.orchestrator.step()
colors = mask.get_data()["data"]
print(np.frombuffer(colors, dtype=np.uint8).reshape(*colors.shape, -1).shape)
"""


@pytest.mark.parametrize(("options", "shape"), [((), "(12, 16, 4)"), (("--replicator", "6"), "(12, 16, 4, 1)")])
def test_a_script_that_unpacks_colors_gets_packed_ones(tmp_path, options, shape):
    (tmp_path / "script.py").write_text(SCRIPT)
    assert usdsdg("run", "-q", *options, "script.py", cwd=tmp_path).stdout.strip() == shape


@pytest.mark.parametrize(
    ("line", "packed"),
    [
        ("np.frombuffer(a['data'], np.uint8).reshape(*a['data'].shape, -1)", True),
        ("a.view(np.uint8).reshape(*a.shape, -1)", True),
        ("a.view(np.uint8).reshape(a.shape[0], a.shape[1], -1)", False),
        ("depth.reshape(*depth.shape, -1)", False),
        ("np.frombuffer(a, np.float32).reshape(*a.shape, -1)", False),
        ("np.frombuffer(a, np.uint8).reshape(*a.shape)", False),
    ],
)
def test_lines_that_only_packed_colors_fit(line, packed):
    assert reads_packed_colors(ast.parse(line)) is packed
