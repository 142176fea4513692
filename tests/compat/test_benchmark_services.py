"""`isaacsim.benchmark.services`: phases, recorders, the summary and its files."""

import json
import time
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image
from pxr import UsdPhysics

from usdsdg.app.app import get_app
from usdsdg.compat.isaacsim.benchmark.services import DEFAULT_RECORDERS, BaseIsaacBenchmark
from usdsdg.compat.isaacsim.benchmark.services.datarecorders import (
    MeasurementData,
    MeasurementDataRecorder,
    MeasurementDataRecorderRegistry,
    Stats,
)
from usdsdg.compat.isaacsim.benchmark.services.metrics import measurements
from usdsdg.compat.isaacsim.benchmark.services.validation import Validator, _blurred
from usdsdg.session.settings.store import get_settings
from usdsdg.session.timeline import get_timeline


@pytest.fixture
def folder(stage, tmp_path):
    get_settings().set("/exts/isaacsim.benchmark.services/metrics/metrics_output_folder", str(tmp_path))
    return tmp_path


def values(file, phase):
    return json.loads(file.read_text())[phase]


def test_a_phase_has_its_run_time_frames_and_memory(folder, capsys):
    benchmark = BaseIsaacBenchmark("laps", workflow_metadata={"metadata": [{"name": "gpus", "data": 2}]})
    benchmark.set_phase("loading", start_recording_frametime=False)
    benchmark.store_measurements()
    benchmark.set_phase("benchmark", warmup_frames=2)
    for _ in range(4):
        get_app().update()
        time.sleep(0.01)
    benchmark.store_measurements()
    benchmark.stop()
    loading, found = (values(folder / "kpis_laps.json", phase) for phase in ("loading", "benchmark"))
    assert found["workflow_name"] == "laps"
    assert found["gpus"] == 2
    assert found["phase"] == "benchmark"
    # The first frame of four is not counted.
    assert found["Num App Updates"] == 3
    assert 10 <= found["Mean App_Update Frametime"] < 200
    assert found["Mean FPS"] == pytest.approx(1000 / found["Mean App_Update Frametime"], rel=1e-3)
    assert 40 <= found["Runtime"] < 2000
    assert 0.01 < found["System Memory RSS"] < found["System Memory VMS"] + 64
    assert "Num App Updates" not in loading
    printed = capsys.readouterr().out
    assert "Summary Report" in printed
    assert all(len(line) == 54 for line in printed.splitlines() if line.startswith("|"))


def test_physics_steps_are_timed(folder, stage):
    UsdPhysics.Scene.Define(stage, "/PhysicsScene")
    recorders = ["physics_frametime", "physics_step_interval", "rtf_stability"]
    benchmark = BaseIsaacBenchmark("physics", backend_type="JSONFileMetrics", recorders=recorders)
    benchmark.set_phase("steps")
    get_timeline().play()
    for _ in range(5):
        get_app().update()
    benchmark.store_measurements()
    benchmark.stop()
    (phase,) = measurements.TestPhase.aggregate_json_files(folder)
    found = {each.name.removeprefix("physics steps "): each for each in phase.measurements}
    assert len(found["Physics Frametime Samples"].value) == 4
    assert all(sample >= 0 for sample in found["Physics Frametime Samples"].value)
    assert found["Physics Step Count"].value == 4
    assert found["Mean Windowed RTF"].value > 0


def test_a_script_adds_recorders_of_its_own(folder):
    @MeasurementDataRecorderRegistry.register("laps")
    class Laps(MeasurementDataRecorder):
        def __init__(self, context=None):
            self.context, self.laps = context, 0

        def get_data(self):
            return MeasurementData([measurements.SingleMeasurement("Laps", self.laps, "laps")])

    benchmark = BaseIsaacBenchmark("own", "OsmoKPIFile", recorders=[*DEFAULT_RECORDERS, "laps"])
    (own,) = (each for each in benchmark.recorders if isinstance(each, Laps))
    own.laps = 3
    benchmark.set_phase("run")
    benchmark.store_measurements()
    benchmark.store_custom_measurement("run", measurements.SingleMeasurement("Best", 1.5, "s"))
    benchmark.stop()
    found = json.loads((folder / "kpis_own_run.json").read_text())
    assert (found["Laps"], found["Best"]) == (3, 1.5)


def test_statistics_are_those_of_numpy():
    samples = list(np.random.default_rng(1).normal(20, 3, 99))
    stats = Stats.from_samples(samples)
    assert stats.stdev == pytest.approx(np.std(samples, ddof=1), abs=0.006)
    assert stats.p99 == pytest.approx(np.quantile(samples, 0.99), abs=0.006)
    trimmed = Stats.from_samples([*range(100)])
    assert (trimmed.min, trimmed.max) == (10, 89)


def test_metadata_of_other_types_is_left_out():
    found = measurements.TestPhase.metadata_from_dict(
        {"metadata": [{"name": "a", "data": None}, {"name": "b", "data": True}, {"name": "c", "data": 1.5}]}
    )
    assert [each.name for each in found] == ["c"]


def write(file, image):
    file.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(image).save(file)


def test_frames_are_compared_with_those_of_an_earlier_run(tmp_path):
    image = np.full((8, 8, 3), 100, np.uint8)
    for index, off in enumerate((0, 4, 9)):
        write(tmp_path / "new" / "cam" / "rgb" / f"rgb_{index:04}.png", image + off)
        write(tmp_path / "old" / "cam" / "rgb" / f"rgb_{index:04}.png", image)
    args = SimpleNamespace(tolerance=5.0, blur_kernel=3)
    found = Validator.from_cli_args(args).validate_frames(str(tmp_path / "new"), str(tmp_path / "old"))
    assert (found["total"], found["passed"], found["failed"]) == (1, 0, 1)
    assert [each["mean_diff"] for each in found["render_products"]["cam"]["frame_results"]] == [0, 4, 9]
    validator = Validator(tolerance=5.0)
    validator.rename_captured_frames_to_timestamps(str(tmp_path / "new"), [0.5, 0.6, 0.7])
    validator.rename_captured_frames_to_timestamps(str(tmp_path / "old"), [0.504, 0.604, 0.9])
    found = validator.validate_frames_by_timestamp(str(tmp_path / "new"), str(tmp_path / "old"))
    assert (found["total"], found["passed"], found["failed"]) == (3, 2, 1)


def test_the_blur_keeps_the_mean_and_spreads_a_point():
    image = np.zeros((9, 9), np.float32)
    image[4, 4] = 81.0
    blurred = _blurred(image, 3)
    assert blurred.sum() == pytest.approx(81.0)
    assert blurred[4, 4] > blurred[4, 3] > blurred[3, 3] > 0 == blurred[4, 2]


def test_times_of_the_gpu_alone_are_not_recorded():
    with pytest.warns(UserWarning, match="gpu_frametime is ignored"):
        BaseIsaacBenchmark("gpu", gpu_frametime=True)
