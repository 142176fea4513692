"""A sample of `python -m tests.soak programs`: a random script leaves the same files in each way to run it."""

import pytest

from tests.programs.blocks import Block, Script
from tests.programs.random_programs import RandomScript
from tests.programs.ways import compared, difference, shrunk
from tests.sampled_cases import in_soak

SEED = 16  # a run without physics


@pytest.mark.parametrize("seed", range(20))
def test_a_seed_gives_one_script(seed):
    text = RandomScript(seed).make().text
    compile(text, "script.py", "exec")
    assert RandomScript(seed).make().text == text


def test_what_does_not_matter_is_left_out():
    script = Script([Block("a = 1"), Block("with a:", [Block("b = 2"), Block("c = 3")]), Block("d = 4")])
    smallest = shrunk(script, lambda some: "c = 3" in some.text)
    assert [block.line for block in smallest.blocks] == ["c = 3"]


@pytest.mark.parametrize(
    "way", ["shards", pytest.param("resumed", marks=in_soak), pytest.param("parts", marks=in_soak)]
)
def test_a_random_script_leaves_the_same_files(way, tmp_path):
    assert not difference(RandomScript(SEED).make(), "plain", tmp_path, SEED)
    assert not compared(way, tmp_path, SEED)
