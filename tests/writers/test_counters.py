"""What writers count is read from their source; those that keep more must say what they skip."""

import pytest

from usdsdg.errors import Unsupported
from usdsdg.writers import counters
from usdsdg.writers.base import Writer


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
