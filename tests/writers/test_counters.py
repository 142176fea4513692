"""What writers count is read from their source; those that keep more must say what they skip."""

import numpy as np
import pytest

from usdsdg.errors import Unsupported, WriterError
from usdsdg.writers import counters
from usdsdg.writers.base import Writer
from usdsdg.writers.formats.pose.writer_pose import PoseWriter
from usdsdg.writers.formats.writer_basic import BasicWriter


class Counting(Writer):
    def write(self, data):
        self._name(data)
        self.count += 2
        self.down -= 1

    def _name(self, data):
        return f"{self.count}_{data}"


class Listing(Writer):
    def write(self, data):
        self.names.append(data)


class Sometimes(Writer):
    def write(self, data):
        if data:
            self.count += 1


class Deep(Writer):
    def write(self, data):
        self._note(data)

    def _note(self, data):
        self.last[0] = data


class ByItself(Listing):
    def skip(self, data):
        self.names.append(None)


def test_counters_advance_as_write_advances_them():
    writer = Counting()
    writer.count, writer.down = 5, 0
    writer.receive_skipped({})
    assert (writer.count, writer.down, writer.num_written) == (7, -1, 1)


@pytest.mark.parametrize(
    ("kind", "what"), [(Listing, "self.names.append"), (Sometimes, "self.count"), (Deep, "self.last")]
)
def test_more_than_counters_is_an_error_that_names_it(kind, what):
    with pytest.raises(Unsupported, match=what):
        counters.advance(kind())


def test_a_writer_that_says_what_it_skips_is_asked():
    writer = ByItself()
    writer.names = []
    writer.receive_skipped({})
    assert writer.names == [None]


class Child(Counting):
    def write(self, data):
        super().write(data)
        self.extra += 1


class SometimesChild(Counting):
    def write(self, data):
        if data:
            super().write(data)


class Leaving(Writer):
    def write(self, data):
        if data is None:
            return
        self.count += 1


class Items(Writer):
    def write(self, data):
        self.counts["all"] += 1


class Unpacked(Writer):
    def write(self, data):
        _name, self.last = data


class OwnBasic(BasicWriter):
    """Counts files beside those of its base, whose `skip` knows nothing of them."""

    extra = 0

    def write(self, data):
        super().write(data)
        self.extra += 1


class ReplacedBasic(BasicWriter):
    def write(self, data):
        self._frame_id += 1


class ListingBasic(BasicWriter):
    def write(self, data):
        super().write(data)
        self.names.append(data)


class Forgetful(Writer):
    kept = ("total",)

    def write(self, data):
        self.total = self.total + len(data)
        self.count += 1


class ForgetfulPose(PoseWriter):
    """Has the `kept` of its base."""

    count = 0

    def write(self, data):
        super().write(data)
        self.count += 3


class ForgetfulDeep(Deep):
    kept = ("count",)


def test_counters_of_a_writer_and_of_its_base_are_advanced():
    writer = Child()
    writer.count = writer.down = writer.extra = 0
    writer.receive_skipped({})
    assert (writer.count, writer.down, writer.extra) == (2, -1, 1)


@pytest.mark.parametrize(
    ("kind", "what"),
    [
        (SometimesChild, "self.count"),
        (Leaving, "self.count"),
        (Items, "self.counts"),
        (Unpacked, "self.last"),
    ],
)
def test_what_is_not_done_at_each_frame_is_no_counter(kind, what):
    with pytest.raises(Unsupported, match=what):
        counters.advance(kind())


def test_a_write_that_counts_more_than_the_skip_of_its_base_is_advanced(tmp_path):
    writer = OwnBasic(output_dir=str(tmp_path), rgb=True)
    writer.receive_skipped({"trigger_outputs": {}})
    writer.receive_made({"trigger_outputs": {}})
    assert (writer._frame_id, writer.extra) == (2, 2)


def test_what_the_skip_of_a_base_does_is_not_done_twice(tmp_path):
    writer = ReplacedBasic(output_dir=str(tmp_path), rgb=True)
    writer.receive_skipped({"trigger_outputs": {}})
    assert writer._frame_id == 1


@pytest.mark.parametrize("receive", ["receive_skipped", "receive_made"])
def test_a_write_that_keeps_more_than_the_skip_of_its_base_is_refused(receive, tmp_path):
    writer = ListingBasic(output_dir=str(tmp_path), rgb=True)
    with pytest.raises(Unsupported, match=r"self\.names\.append\(\).*of which the `skip` of BasicWriter does not know"):
        getattr(writer, receive)({"trigger_outputs": {}})


def test_counters_that_kept_leaves_out_are_advanced(tmp_path):
    writer = Forgetful()
    writer.total, writer.count = 7, 0
    writer.receive_made({})
    assert (writer.total, writer.count, writer.num_written) == (7, 1, 1)
    pose = ForgetfulPose(output_dir=str(tmp_path))
    pose.receive_made({})
    assert pose.count == 3


def test_what_kept_leaves_out_beside_counters_is_refused():
    with pytest.raises(Unsupported, match=r"self\.last in line 2 of _note.*`kept` does not name"):
        ForgetfulDeep().receive_made({})


def test_what_was_not_in_kept_when_frames_were_made_is_refused():
    writer = Forgetful()
    counters.restore(writer, {})
    counters.restore(writer, {"total": 5, "other": 2})
    assert writer.total == 5
    writer.kept = ("total", "count")
    with pytest.raises(Unsupported, match="`kept` names count, of which the journal has no value"):
        counters.restore(writer, {"total": 5})


def test_what_is_kept_is_a_copy_in_json():
    writer = Forgetful()
    writer.kept, writer.names, writer.total = ("names", "total"), ["a"], np.int64(3)
    kept = counters.kept_of(writer)
    writer.names.append("b")
    assert kept == {"names": ["a"], "total": 3}
    assert type(kept["total"]) is int


@pytest.mark.parametrize(("value", "said"), [(np.zeros(2), "an? ndarray"), ({1, 2}, "a set"), (None, "no attribute")])
def test_what_cannot_be_kept_is_named(value, said):
    writer = Forgetful()
    if value is not None:
        writer.total = value
    with pytest.raises(WriterError, match=f"Forgetful.*{said}"):
        counters.kept_of(writer)


def test_one_name_may_be_kept():
    class One(Writer):
        kept = "total"

        def write(self, data):
            pass

    assert One.kept == ("total",)
