"""Scripts whose last line waits until a person closes their window."""

import pytest

from tests.scripts.conftest import usdsdg
from usdsdg.app.window_wait import IDLE_UPDATES, WindowWait

WAITS = """
import os
from isaacsim import SimulationApp
app = SimulationApp({"headless": False})
import omni.replicator.core as rep
cube = rep.create.cube(semantics=[("class", "cube")])
with rep.trigger.on_frame():
    with cube:
        rep.modify.pose(position=rep.distribution.uniform((-1, -1, 0), (1, 1, 0)))
writer = rep.WriterRegistry.get("BasicWriter")
writer.initialize(output_dir=os.path.abspath("out"), bounding_box_2d_tight=True)
writer.attach(rep.create.render_product(rep.create.camera(position=(0, -5, 1), look_at=cube), (16, 16)))
while app.is_running():
    app.update()
print("the window is closed")
app.close()
"""
WORKS = """
import asyncio
from isaacsim import SimulationApp
app = SimulationApp()
import omni.kit.app, omni.timeline
timeline = omni.timeline.get_timeline_interface()
timeline.play()
for number in range(3000):
    assert app.is_running(), "it plays"
    app.update()
timeline.stop()
async def wait():
    for number in range(3000):
        await omni.kit.app.get_app().next_update_async()
task = asyncio.ensure_future(wait())
while app.is_running() and not task.done():
    app.update()
print("done", task.done())
"""


def test_a_limit_of_frames_stands_for_closing_the_window_and_for_start(tmp_path):
    (tmp_path / "script.py").write_text(WAITS)
    done = usdsdg("run", "-q", "--frames", "1", "--new-stage", "isaac", "script.py", cwd=tmp_path)
    assert "the window is closed" in done.stdout
    assert sorted(file.name for file in (tmp_path / "out").glob("bounding_box_2d_tight_0*.npy")) == [
        "bounding_box_2d_tight_0000.npy",
        "bounding_box_2d_tight_0001.npy",
    ]


def test_what_plays_or_waits_is_not_ended(tmp_path):
    (tmp_path / "script.py").write_text(WORKS)
    assert usdsdg("run", "-q", "--frames", "1", "script.py", cwd=tmp_path).stdout.strip() == "done True"


def test_without_a_limit_it_goes_on_with_one_warning():
    wait = WindowWait()
    with pytest.warns(UserWarning, match="window is closed.*--frames N") as seen:
        assert not any(wait.is_over(update, idle=True, ends=False) for update in range(2 * IDLE_UPDATES))
    assert len(seen) == 1


def test_only_questions_after_each_update_count():
    wait = WindowWait()
    assert not any(wait.is_over(update, idle=True, ends=True) for update in range(0, 4 * IDLE_UPDATES, 2))
    assert not any(wait.is_over(update, idle=update % 500 > 0, ends=True) for update in range(4 * IDLE_UPDATES))
    assert any(wait.is_over(update, idle=True, ends=True) for update in range(IDLE_UPDATES + 1))
