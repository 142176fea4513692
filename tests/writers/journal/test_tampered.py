"""Recipes, journals and spools that someone has changed: errors of one line, whatever reads them."""

import json
import random
import shutil
import warnings
from contextlib import suppress

import pytest

from tests.writers.journal.test_folders import recipe, run, write_frame
from usdsdg.errors import UsdsdgError
from usdsdg.session import session
from usdsdg.verify import verify
from usdsdg.workers.plan import plan
from usdsdg.writers.journal import recipe as recipe_file
from usdsdg.writers.journal.folders import DatasetFolder, Mode
from usdsdg.writers.journal.place import FolderPlace
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


@pytest.mark.parametrize("use", USES)
@pytest.mark.parametrize("which", ["whole", "parts"])
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
