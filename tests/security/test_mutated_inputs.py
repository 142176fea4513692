"""A sample of `python -m tests.soak inputs`: mutated files end in an error, a warning, or the same picture."""

import pytest

from tests.sampled_cases import sampled
from tests.soak.inputs import Trials


@pytest.fixture(scope="module")
def trials(tmp_path_factory):
    found = Trials(tmp_path_factory.mktemp("inputs"))
    yield found
    found.close()


@pytest.mark.parametrize("seed", sampled(range(18), 6))
def test_a_mutated_file_is_refused_or_told_of(trials, seed):
    original = trials.originals[seed % len(trials.originals)]
    word, line = trials.run(original, seed)
    assert word != "failed", line
