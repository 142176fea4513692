"""`usdsdg verify` finds damaged values and tables without a journal, names their file, and never ends in a traceback."""

import os
import shutil
import subprocess
import sys

import pytest

from tests.sampled_cases import sampled
from tests.verify import damaged, damaged_values, datasets
from usdsdg.cli.commands import app
from usdsdg.datasets.faults import Fault
from usdsdg.errors import DatasetError
from usdsdg.verify import verify


@pytest.fixture(scope="module")
def clean(tmp_path_factory):
    needed = sorted({each.dataset for each in damaged_values.ALL} | {"yolo"})
    return datasets.make(tmp_path_factory.mktemp("datasets"), needed, frames=4)


def damaged_copy(clean, tmp_path, damage):
    """Return a damaged copy, which has no journal, and the file that was damaged."""
    folder = shutil.copytree(clean / damage.dataset, tmp_path / "data")
    if damage.name == "a picture without a number":
        shutil.copy(folder / "train_pbr/000000/rgb/000000.png", folder / damage.file)
    file = damaged_values.found(folder, damage)
    damage.inject(file)
    return folder, file.relative_to(folder).as_posix()


@pytest.mark.parametrize("damage", damaged_values.ALL, ids=[each.name for each in damaged_values.ALL])
def test_a_damaged_value_is_found(clean, tmp_path, damage):
    folder, file = damaged_copy(clean, tmp_path, damage)
    assert file in {fault.file.split(":")[0] for fault in verify(folder).faults}
