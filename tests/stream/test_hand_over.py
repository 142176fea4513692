"""A function in a thread that hands over items."""

import threading

import pytest

from usdsdg.stream.hand_over import Closed, HandOver


def test_items_arrive_in_order_and_few_wait():
    made = []

    def work(put):
        for number in range(20):
            made.append(number)
            put(number)

    hand_over = HandOver(work, waiting=2)
    items = iter(hand_over)
    assert [next(items) for _ in range(5)] == [0, 1, 2, 3, 4]
    # Five are taken, two wait, one is in the hands of `put`.
    assert len(made) <= 8
    assert list(items) == list(range(5, 20))


def test_a_failure_is_raised_after_the_items_before_it():
    def work(put):
        put(1)
        raise ValueError("no more")

    items = iter(HandOver(work, waiting=1))
    assert next(items) == 1
    with pytest.raises(ValueError, match="no more"):
        next(items)


def test_closing_ends_the_function_though_it_catches_exceptions():
    ended = threading.Event()
    seen = []

    def work(put):
        try:
            while True:
                try:
                    put(0)
                except Exception as error:  # noqa: BLE001 - as scripts do
                    seen.append(error)
        except Closed:
            ended.set()
            raise

    hand_over = HandOver(work, waiting=1)
    assert next(iter(hand_over)) == 0
    hand_over.close()
    assert ended.is_set()
    assert not seen
