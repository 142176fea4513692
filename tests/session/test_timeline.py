"""The timeline and the time metadata of the stage, which follow each other."""

import math

import pytest
from pxr import Usd

from usdsdg.errors import BadValue
from usdsdg.session.stage_context import new_stage, open_stage
from usdsdg.session.timeline import get_timeline, stage_time

pytestmark = pytest.mark.usefixtures("stage")


def range_of(timeline):
    return timeline.get_start_time(), timeline.get_end_time()


def test_the_rate_that_a_script_authors_is_that_of_the_timeline():
    stage, timeline = new_stage(), get_timeline()
    stage.SetTimeCodesPerSecond(24)
    assert timeline.get_time_codes_per_second() == 24.0
    timeline.play()
    timeline.forward_one_frame()
    assert timeline.get_current_time() == pytest.approx(1 / 24)


def test_the_range_that_a_script_authors_is_that_of_the_timeline():
    stage, timeline = new_stage(), get_timeline()
    stage.SetStartTimeCode(30)
    stage.SetEndTimeCode(120)
    assert range_of(timeline) == (0.5, 2.0)
    stage.SetTimeCodesPerSecond(30)
    assert range_of(timeline) == (1.0, 4.0)


def test_an_end_alone_is_a_range_from_zero():
    stage, timeline = new_stage(), get_timeline()
    stage.SetEndTimeCode(60)
    assert range_of(timeline) == (0.0, 1.0)


def test_playback_wraps_at_the_end_that_was_authored():
    stage, timeline = new_stage(), get_timeline()
    stage.SetEndTimeCode(2)
    timeline.play()
    for _ in range(3):
        timeline.forward_one_frame()
    assert timeline.get_current_time() == pytest.approx(1 / 60)


def test_the_rate_that_is_set_on_the_timeline_is_authored_on_the_root_layer():
    stage, timeline = new_stage(), get_timeline()
    stage.SetEditTarget(Usd.EditTarget(stage.GetSessionLayer()))
    timeline.set_end_time(10.0)
    timeline.set_time_codes_per_second(30)
    assert stage.GetRootLayer().timeCodesPerSecond == 30.0
    assert stage_time(stage) == Usd.TimeCode(0.0)
    assert range_of(timeline) == (0.0, 10.0), "the range stays in seconds"


def test_a_range_that_is_set_on_the_timeline_survives_another_rate_of_the_stage():
    stage, timeline = new_stage(), get_timeline()
    timeline.set_end_time(10.0)
    stage.SetTimeCodesPerSecond(30)
    assert range_of(timeline) == (0.0, 10.0)
    stage.SetEndTimeCode(30)
    assert range_of(timeline) == (0.0, 1.0)


def test_a_new_stage_has_the_usual_rate_again():
    get_timeline().set_time_codes_per_second(30)
    stage = new_stage()
    assert stage.GetTimeCodesPerSecond() == get_timeline().get_time_codes_per_second() == 60.0


@pytest.mark.parametrize("seconds", [math.nan, -math.inf, 1e300])
def test_a_time_that_has_no_time_stamp_is_an_error(seconds):
    with pytest.raises(BadValue, match="set_current_time"):
        get_timeline().set_current_time(seconds)
    assert get_timeline().get_current_time() == 0.0


def test_frames_of_older_files_are_a_range(tmp_path):
    file = tmp_path / "old.usda"
    file.write_text("#usda 1.0\n(\n    startFrame = 48\n    endFrame = 72\n    timeCodesPerSecond = 24\n)\n")
    open_stage(file)
    assert range_of(get_timeline()) == (2.0, 3.0)
    assert get_timeline().get_current_time() == 2.0


def test_a_range_of_a_stage_that_has_no_time_stamps_is_an_error():
    stage = new_stage()
    stage.SetStartTimeCode(0.0)
    stage.SetEndTimeCode(1e300)
    with pytest.raises(BadValue, match="startTimeCode and endTimeCode"):
        get_timeline().get_end_time()


@pytest.mark.parametrize("rate", [0, -1, 1e-300, math.nan, math.inf])
def test_a_rate_that_is_no_rate_is_an_error(rate):
    stage = new_stage()
    with pytest.raises(BadValue, match="finite number > 0"):
        get_timeline().set_time_codes_per_second(rate)
    stage.SetTimeCodesPerSecond(rate)
    with pytest.raises(BadValue, match="timeCodesPerSecond"):
        get_timeline().get_time_codes_per_second()
