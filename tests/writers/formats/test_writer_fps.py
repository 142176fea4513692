"""FPSWriter: what it prints."""

import pytest

from tests.annotators.ray_caster import known, make_frame, new_stage
from usdsdg import annotators, writers
from usdsdg.writers.formats import writer_fps

PRODUCT = "/Render/HydraTextures/rp1"


@pytest.fixture
def clock(monkeypatch):
    """Moments at which frames come."""
    moments = iter([10.0, 10.5, 12.0, 99.0, 99.25])
    monkeypatch.setattr(writer_fps.time, "perf_counter", lambda: next(moments))


def receive(writer, count):
    frame = make_frame(new_stage(), (4, 3))
    for _ in range(count):
        writer.receive(annotators.build_payload(writer, {PRODUCT: frame}))


def test_it_prints_the_time_of_each_frame_and_the_mean(clock, capsys):
    writer = writers.get("FPSWriter", init_params={}, render_products=known(PRODUCT))
    receive(writer, 3)
    writer.on_final_frame()
    assert capsys.readouterr().out.splitlines() == ["0.5", "1.5", "COMPLETE", "AVERAGE TIME PER FRAME: 1.0"]
    # The pause between two runs is no frame.
    receive(writer, 2)
    writer.on_final_frame()
    assert capsys.readouterr().out.splitlines() == ["0.25", "COMPLETE", "AVERAGE TIME PER FRAME: 0.75"]
    assert writer.times_per_frame == [0.5, 1.5, 0.25]


def test_without_two_frames_there_is_nothing_to_tell(clock, capsys):
    writer = writers.get("FPSWriter", init_params={}, render_products=known(PRODUCT))
    receive(writer, 1)
    writer.on_final_frame()
    assert capsys.readouterr().out == ""


def test_it_has_pictures_rendered_and_writes_nothing():
    writer = writers.get("FPSWriter", init_params={}, render_products=known(PRODUCT))
    assert list(writer.get_annotators()) == ["LdrColor"]
    assert writer.backend is None
