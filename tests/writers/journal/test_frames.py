"""Captured frames whose files are being written: which of them journals list, and in which order."""

from usdsdg.writers.journal.frames import FramesInHand


def begun(frames, number, *folders):
    frame = frames.begin(number)
    for folder in folders:
        frame.touch(folder)
    return frame


def test_frames_are_whole_in_their_order():
    frames = FramesInHand()
    first, second = (begun(frames, number, "a") for number in range(2))
    second.release()
    assert (frames.count_whole(), frames.whole(), frames.lacks("a")) == (0, [], True)
    first.release()
    assert (frames.count_whole(), frames.lacks("a")) == (2, False)
    assert frames.whole() == frames.whole() == [first, second]
    third = begun(frames, 2, "a")
    third.release()
    frames.forget([first, second])
    assert frames.whole() == [third]


def test_a_frame_that_fails_keeps_later_ones_of_its_folders_out():
    """And those of folders that had a frame which is kept out so: journals have no gaps."""
    frames = FramesInHand()
    whole = [begun(frames, 0, "a", "b", "c")]
    failed = begun(frames, 1, "a")
    between = begun(frames, 2, "a", "b")
    after = begun(frames, 3, "b")
    whole.append(begun(frames, 4, "c"))
    for frame in (*whole, between, after):
        frame.release()
    failed.release(failed=True)
    assert frames.whole() == whole
    assert [frames.lacks(folder) for folder in "abc"] == [True, True, False]


def test_a_failed_frame_of_a_writer_without_a_folder_keeps_nothing_out():
    frames = FramesInHand()
    begun(frames, 0).release(failed=True)
    frame = begun(frames, 1, "a")
    frame.release()
    assert frames.whole() == [frame]
    assert not frames.lacks("a")
