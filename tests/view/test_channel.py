"""A slow page gets fewer pictures, and never old ones."""

from usdsdg.view.channel import IN_FLIGHT, Channel


def test_of_pictures_that_wait_only_the_latest_is_sent():
    channel = Channel(lambda: None)
    for number in range(5):
        channel.show("view", {"number": number}, b"")
    channel.show("camera", {"number": 9}, b"")
    sent = channel.outgoing()
    assert [b'"number":4' in each or b'"number":9' in each for each in sent] == [True, True]
    assert channel.outgoing() == []


def test_the_next_picture_waits_until_the_page_has_shown_one():
    channel = Channel(lambda: None)
    for _ in range(IN_FLIGHT):
        assert channel.wants_pictures
        channel.show("view", {}, b"")
        channel.outgoing()
    assert not channel.wants_pictures
    channel.note_shown()
    assert channel.wants_pictures


def test_a_picture_that_is_replaced_before_it_is_sent_is_not_waited_for():
    channel = Channel(lambda: None)
    for _ in range(10):
        channel.show("view", {}, b"")
    assert channel.wants_pictures
    channel.outgoing()
    channel.note_shown()
    channel.note_shown()  # more than were sent count for nothing
    for _ in range(IN_FLIGHT):
        assert channel.wants_pictures
        channel.show("view", {}, b"")
        channel.outgoing()
    assert not channel.wants_pictures


def test_values_are_never_left_out():
    channel = Channel(lambda: None)
    channel.tell(a=1)
    channel.tell(a=2)
    assert channel.outgoing() == ['{"a":1}', '{"a":2}']


def test_a_closed_page_wants_nothing():
    woken = []
    channel = Channel(lambda: woken.append(1))
    channel.close()
    assert woken
    assert not channel.wants_pictures
