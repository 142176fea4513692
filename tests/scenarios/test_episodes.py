"""Episodes: each has frames from a seed of its own, and processes pass over those of others."""

import pytest

from tests.cli.datasets import content, generate, merge, write_job
from tests.sampled_cases import in_soak
from usdsdg.cli.commands.generate import make_part
from usdsdg.scenarios.episodes import Episode, episodes


def test_without_episodes_all_frames_have_the_seed_of_the_job():
    assert list(episodes(7, 10, 0)) == [Episode(0, 10, 7)]
    assert list(episodes(7, 10, 10)) == [Episode(0, 10, 7)]
    assert list(episodes(7, 0, 0)) == [Episode(0, 0, 7)]


def test_episodes_have_every_frame_once_and_seeds_of_their_own():
    found = list(episodes(7, 10, 4))
    assert len(episodes(7, 10, 4)) == len(found)
    assert [(each.first, each.frames) for each in found] == [(0, 4), (4, 4), (8, 2)]
    assert len({each.seed for each in found} | {7}) == 4
    assert list(episodes(7, 100, 4))[:2] == found[:2]
    assert next(iter(episodes(8, 10, 4))).seed != found[0].seed


def test_a_billion_episodes_are_there_at_once():
    found = episodes(7, 10**9, 1)
    assert len(found) == 10**9
    assert next(iter(found)).frames == 1


@in_soak
@pytest.mark.parametrize("writer", ["CocoWriter", "BasicWriter"])
def test_a_part_passes_over_the_episodes_of_others(tmp_path, writer):
    labels = {"rgb": False, "semantic_segmentation": True}
    job = write_job(tmp_path, writer, **({"splits": {"train": 2, "val": 1}} if writer == "CocoWriter" else labels))
    keys = ("--set", "frames_per_episode=2", "--set", "path_tracing.every=0")
    whole = generate(job, tmp_path / "whole", *keys, fresh=True)
    assert whole.returncode == 0, whole.stderr
    for frames in ("4:6", "0:4"):
        done = generate(job, tmp_path / "out", *keys, "--frames", frames)
        assert done.returncode == 0, done.stderr
    assert merge(tmp_path / "out").returncode == 0
    assert content(tmp_path / "out") == content(tmp_path / "whole")
    pictures = [data for name, data in content(tmp_path / "whole").items() if name.endswith(".png")]
    assert len(set(pictures)) > 1


def test_a_part_without_the_last_episode_has_come_to_its_end(tmp_path):
    job = write_job(tmp_path, "BasicWriter", rgb=False, semantic_segmentation=True)
    given = ["generate", "-q", str(job), "--device", "cpu", "--set", f"writer_kwargs.output_dir={tmp_path}/out"]
    keys = ("--set", "num_frames=2", "--set", "frames_per_episode=1", "--set", "path_tracing.every=0")
    for shard in ("0/2", "1/2"):
        code, said = make_part([*given, *keys, "--shard", shard])
        assert code == 0, said
    assert merge(tmp_path / "out").returncode == 0
    assert len(list((tmp_path / "out").rglob("semantic_segmentation_*.png"))) == 2 * 2
