"""Several processes make the dataset that one makes, whoever of them dies."""

import pytest

from tests.cli.datasets import FRAMES, content, generate, merge, write_job
from tests.sampled_cases import in_soak, sampled
from tests.soak.kills import Trials
from usdsdg.errors import DatasetError
from usdsdg.workers.plan import Part, plan
from usdsdg.writers.journal.journal import Journal
from usdsdg.writers.journal.places.place import PARTS, FolderPlace


@pytest.fixture(scope="module")
def trials(tmp_path_factory):
    return Trials(tmp_path_factory.mktemp("trials"), most_ends=2)


@pytest.mark.parametrize("how", sampled(["kill", "worker"]))
def test_a_run_that_is_killed_and_gone_on_with_is_whole(trials, how):
    assert trials.run(how, seed=1) is None


@in_soak
def test_two_workers_make_what_one_process_makes_and_go_on_with_its_frames(tmp_path):
    job = write_job(tmp_path, "CocoWriter", splits={"train": 2, "val": 1})
    assert generate(job, tmp_path / "whole").returncode == 0
    assert generate(job, tmp_path / "out", "--frames", "0:2").returncode == 0
    early = merge(tmp_path / "out")
    assert early.returncode == 0, early.stderr
    done = generate(job, tmp_path / "out", "--workers", "2", "--overwrite")
    assert done.returncode == 0, done.stderr
    assert f"{FRAMES} frames in" in done.stdout
    assert f"dataset: {tmp_path / 'out'}" in done.stdout
    assert content(tmp_path / "out") == content(tmp_path / "whole")
    done = generate(job, tmp_path / "out", "--workers", "2", "--resume")  # when nothing is left to be made
    assert done.returncode == 0, done.stderr
    assert content(tmp_path / "out") == content(tmp_path / "whole")


def test_workers_say_what_is_wrong_with_a_job_once(tmp_path):
    job = write_job(tmp_path, "CocoWriter")
    done = generate(
        job, tmp_path / "out", "--workers", "2", "--set", "labeled_assets_and_properties.0.url=/no/such.usd"
    )
    assert done.returncode == 1
    assert "/no/such.usd" in done.stderr
    assert "Traceback" not in done.stderr
    wrong = generate(job, tmp_path / "out", "--workers", "2", "--frames", "0:2")
    assert wrong.returncode == 1
    assert "--workers makes all frames" in wrong.stderr


def begin(folder, name, frames, complete):
    home = folder / PARTS / name
    home.mkdir(parents=True)
    journal = Journal(home / "journal.jsonl")
    journal.append([{"frame": number, "files": {}} for number in frames], {})
    if complete:
        journal.close(complete=True)


def test_a_plan_has_every_frame_that_is_missing_once(tmp_path):
    assert plan([FolderPlace(tmp_path)], 10, 3) == [Part(0, 3), Part(3, 6), Part(6, 10)]
    assert plan([FolderPlace(tmp_path)], 2, 7) == [Part(0, 1), Part(1, 2)]
    assert plan([FolderPlace(tmp_path)], 10, 3, unit=4) == [Part(0, 4), Part(4, 8), Part(8, 10)]
    assert plan([FolderPlace(tmp_path)], 10, 2, unit=4) == [Part(0, 4), Part(4, 10)]
    begin(tmp_path, "0-3", range(3), complete=True)
    begin(tmp_path, "6-10", range(6, 8), complete=False)
    assert plan([FolderPlace(tmp_path)], 10, 3) == [Part(3, 6), Part(6, 10)]
    assert plan([FolderPlace(tmp_path)], 20, 4) == [Part(3, 6), Part(6, 10), Part(10, 15), Part(15, 20)]


def test_frames_of_one_process_that_died_are_a_part(tmp_path):
    (tmp_path / ".usdsdg").mkdir()
    Journal(tmp_path / ".usdsdg/journal.jsonl").append([{"frame": number, "files": {}} for number in range(4)], {})
    assert plan([FolderPlace(tmp_path)], FRAMES, 1) == [Part(4, FRAMES)]
    assert plan([FolderPlace(tmp_path)], FRAMES, 1) == [Part(4, FRAMES)]


def test_parts_that_overlap_or_are_shards_are_errors(tmp_path):
    begin(tmp_path, "0-3", range(3), complete=True)
    begin(tmp_path, "2-5", range(2, 5), complete=True)
    with pytest.raises(DatasetError, match="overlap at frame 2"):
        plan([FolderPlace(tmp_path)], 10, 2)
    begin(tmp_path, "1-of-2", (1, 3), complete=True)
    with pytest.raises(DatasetError, match="1-of-2"):
        plan([FolderPlace(tmp_path)], 10, 2)
