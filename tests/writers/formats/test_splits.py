"""Shares of the parts of a dataset."""

import warnings

import pytest

from usdsdg.errors import UsdsdgWarning, WriterError
from usdsdg.writers.formats.splits import Splits


@pytest.mark.parametrize(
    ("shares", "told"),
    [
        ({"train": 0.8, "val": 0.4}, r"add up to 1\.2\. .*: 67% train, 33% val"),
        ({"train": 1, "val": 0.25}, r"add up to 1\.25\. .*: 80% train, 20% val"),
        ({"train": 0.7, "val": 0.2}, r"add up to 0\.9\. .*: 78% train, 22% val"),
    ],
)
def test_shares_that_do_not_add_up_are_told(shares, told):
    with pytest.warns(UsdsdgWarning, match=f"Writer: splits {told}"):
        Splits("Writer", shares)


@pytest.mark.parametrize(
    "shares",
    [None, {"train": 0.8, "val": 0.2}, {"a": 0.33, "b": 0.33, "c": 0.33}, {"train": 8, "val": 2}, {"a": 1, "b": 1}],
)
def test_shares_of_one_and_relative_sizes_are_as_meant(shares):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Splits("Writer", shares)


@pytest.mark.parametrize("share", [0, -1, float("nan"), float("inf"), "1"])
def test_shares_are_finite_numbers_above_0(share):
    with pytest.raises(WriterError, match="expected shares above 0"):
        Splits("Writer", {"train": share, "val": 1})
