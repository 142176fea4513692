"""Recipes, journals and spools that someone has changed: errors of one line, whatever reads them."""

import json
import random
import shutil
import warnings
from contextlib import suppress

import pytest

from tests.cli.datasets import content
from tests.sampled_cases import crossed
from tests.writers.journal.test_folders import recipe, run, write_frame
from usdsdg.errors import DatasetError, UsdsdgError
from usdsdg.session import session
from usdsdg.verify import verify
from usdsdg.workers.plan import plan
from usdsdg.writers import parts
from usdsdg.writers.journal import merge
from usdsdg.writers.journal import recipe as recipe_file
from usdsdg.writers.journal.earlier_run import Mode
from usdsdg.writers.journal.folders import DatasetFolder
from usdsdg.writers.journal.places.place import FolderPlace
from usdsdg.writers.journal.portion import Portion
from usdsdg.writers.journal.recipe import Recipe
from usdsdg.writers.parts import join_parts

ODD = (None, True, -1, 1.5, "", "../../up", "a\0b", [], {}, [[]], {"a": 1}, [1, 2], 10**30, "9" * 10_000)
RECORDS = '{{"kind": "TrainList"}}\n{{"about": {{"list": "train.txt"}}}}\n{}\n'


@pytest.fixture(scope="module")
def datasets(tmp_path_factory):
    """A whole dataset, and one in two parts that are not joined."""
    top = tmp_path_factory.mktemp("datasets")
    run(top / "whole", frames=(0, 1))
    for first in (0, 2):
        folder = DatasetFolder(FolderPlace(top / "parts"), recipe(), Mode.NEW, Portion(first, first + 2))
        folder.note_facts("writers", {"YCBVideoWriter-0": {"num_frames": 4}})
        for number in (first, first + 1):
            write_frame(folder, number)
        folder.aggregates.mkdir(parents=True)
        lines = "\n".join(f'{{"frame": {number}, "number": {number}}}' for number in (first, first + 1))
        (folder.aggregates / "train.jsonl").write_text(RECORDS.format(lines))
        folder.close(complete=True)
    return top


def changed(value, draw):
    """A value of JSON with one place in it changed."""
    if isinstance(value, dict) and value and draw.random() < 0.8:
        name = draw.choice(sorted(value))
        how = draw.random()
        if how < 0.15:
            return {key: each for key, each in value.items() if key != name}
        if how < 0.3:
            return {**value, str(draw.choice(ODD)): draw.choice(ODD)}
        return {**value, name: changed(value[name], draw)}
    if isinstance(value, list) and value and draw.random() < 0.8:
        place = draw.randrange(len(value))
        return [*value[:place], changed(value[place], draw), *value[place + 1 :]]
    return draw.choice(ODD)


def tamper(folder, draw):
    """Change one line of one file that is beside the data; return what was done."""
    files = [each for each in sorted((folder / ".usdsdg").rglob("*")) if each.suffix in (".json", ".jsonl")]
    file = draw.choice([each for each in files if each.stat().st_size])
    if file.suffix == ".json":
        text = json.dumps(changed(json.loads(file.read_text()), draw))
    else:
        lines = file.read_text().splitlines()
        place = draw.randrange(len(lines))
        deep = "[" * 100_000
        lines[place] = deep if draw.random() < 0.05 else json.dumps(changed(json.loads(lines[place]), draw))
        text = "\n".join(lines) + "\n"
    file.write_text(text)
    return f"{file.relative_to(folder)}: {text[:300]}"


def claim(mode, portion=None):
    def use(folder):
        DatasetFolder(FolderPlace(folder), recipe(), mode, portion).close(complete=True)

    return use


def reread(folder):
    values = recipe_file.read(folder)
    Recipe.of_values(values, folder).of(str(folder)).differences(values)


USES = {
    "verify": lambda folder: verify(folder, labels=False),
    "recipe": reread,
    "begin": claim(Mode.NEW),
    "resume": claim(Mode.RESUME),
    "overwrite": claim(Mode.OVERWRITE),
    "replace": claim(Mode.REPLACE),
    "part": claim(Mode.RESUME, Portion(0, 2)),
    "merge": lambda folder: join_parts(FolderPlace(folder)),
    "plan": lambda folder: plan([FolderPlace(folder)], 6, 2),
}


def test_parts_that_nobody_touched_are_joined(datasets, tmp_path):
    shutil.copytree(datasets / "parts", tmp_path / "out")
    assert join_parts(FolderPlace(tmp_path / "out")) == 4
    assert (tmp_path / "out/train.txt").read_text().splitlines() == [f"0000/{number:06}" for number in range(4)]
    session.restart()


@pytest.mark.parametrize(("use", "which"), crossed(USES, ["whole", "parts"]))
def test_what_was_tampered_with_is_refused_or_used_but_never_a_crash(datasets, tmp_path, use, which):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for seed in range(40):
            folder = tmp_path / str(seed) / "out"
            shutil.copytree(datasets / which, folder)
            done = tamper(folder, random.Random(f"{seed} {which}"))
            try:
                with suppress(UsdsdgError):
                    USES[use](folder)
            except Exception as error:
                raise AssertionError(f"seed {seed}: {done}") from error
            finally:
                session.current().run.release()
            assert [each.name for each in (tmp_path / str(seed)).iterdir()] == ["out"]
    session.restart()


def parts_in(folder, names, frames):
    for name, portion in names.items():
        part = DatasetFolder(FolderPlace(folder), recipe(), Mode.NEW, portion)
        for number in frames.get(name, ()):
            write_frame(part, number)
        part.close(complete=True)


def test_a_shard_that_is_missing_is_named_though_no_frame_is(tmp_path):
    shards = {f"{each}/3": Portion.of_shard(f"{each}/3") for each in (0, 1)}
    parts_in(tmp_path / "out", shards, {"0/3": [0], "1/3": [1]})
    parts_in(tmp_path / "other", {"0/4": Portion.of_shard("0/4")}, {"0/4": [0]})
    with pytest.raises(DatasetError, match="shards 1/4, 2/4, 3/4 are missing; make them with --shard"):
        join_parts(FolderPlace(tmp_path / "other"))
    with pytest.raises(DatasetError, match="shard 2/3 is missing; make it with --shard"):
        join_parts(FolderPlace(tmp_path / "out"))
    assert any("shard 2/3 is missing" in fault.what for fault in verify(tmp_path / "out", labels=False).faults)
    parts_in(tmp_path / "out", {"2/3": Portion.of_shard("2/3")}, {})
    assert not any("missing" in fault.what for fault in verify(tmp_path / "out", labels=False).faults)
    assert join_parts(FolderPlace(tmp_path / "out")) == 2
    session.restart()


def test_a_merge_that_died_at_any_step_is_gone_on_with(datasets, tmp_path, monkeypatch):
    class Died(BaseException):
        """As a signal that cannot be caught."""

    shutil.copytree(datasets / "parts", tmp_path / "whole")
    join_parts(FolderPlace(tmp_path / "whole"))
    joined = merge.JOINED.rpartition("/")[2]
    steps = {"journal.jsonl": (merge, "write_whole"), joined: (merge.os, "replace"), "": (parts, "finish_run")}
    for word, (module, name) in steps.items():
        folder = tmp_path / f"{name} {word}"
        shutil.copytree(datasets / "parts", folder)
        goes_on = getattr(module, name)

        def dies(*paths, word=word, goes_on=goes_on, **options):
            if any(str(each).endswith(word) for each in paths) or not word:
                raise Died
            return goes_on(*paths, **options)

        with monkeypatch.context() as patched:
            patched.setattr(module, name, dies)
            with pytest.raises(Died):
                join_parts(FolderPlace(folder))
        session.current().run.release()
        assert join_parts(FolderPlace(folder)) == 4
        assert content(folder) == content(tmp_path / "whole")
    session.restart()


@pytest.mark.parametrize(
    ("remedy", "said"),
    [
        (recipe_file.PUT_BACK, "Give this user the right to read it, or work on a copy of the dataset."),
        (recipe_file.REMOVED, "Choose another output_dir, or make this one a folder that can be read and written."),
    ],
)
def test_a_recipe_that_may_not_be_read_has_the_remedy_of_its_command(remedy, said, tmp_path, monkeypatch):
    def refuse(path):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(type(tmp_path), "read_bytes", refuse)
    with pytest.raises(UsdsdgError) as failure:
        recipe_file.read(tmp_path, remedy=remedy)
    assert str(failure.value) == f"{tmp_path / recipe_file.FILE} cannot be read: Permission denied. {said}"
