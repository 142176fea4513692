"""Captured frames whose files are being written: which of them journals list, and in which order."""

from usdsdg.writers.journal.frames import FramesInHand


def begun(frames, number, *folders):
    frame = frames.begin(number)
    for folder in folders:
        frame.touch(folder)
    return frame


def numbers(frames, folder):
    return [frame.number for frame, where in frames.whole() if where == folder]


def test_frames_are_whole_in_their_order():
    frames = FramesInHand()
    first, second = (begun(frames, number, "a") for number in range(2))
    second.release()
    assert (frames.count_whole(), frames.whole(), frames.lacks("a")) == (0, [], True)
    first.release()
    assert (frames.count_whole(), frames.lacks("a")) == (2, False)
    assert frames.whole() == frames.whole() == [(first, "a"), (second, "a")]
    third = begun(frames, 2, "a")
    third.release()
    frames.forget([(first, "a"), (second, "a")])
    assert frames.whole() == [(third, "a")]


def test_a_file_that_could_not_be_written_keeps_later_frames_of_its_folder_out():
    frames = FramesInHand()
    every = [begun(frames, number, *folders) for number, folders in enumerate(["ab", "ab", "ab", "b"])]
    every[1].hold()
    every[1].release(failed=True, folder="a")
    for frame in every:
        frame.release()
    assert (numbers(frames, "a"), numbers(frames, "b")) == ([0], [0, 1, 2, 3])
    assert [frames.lacks(folder) for folder in "ab"] == [True, False]


def test_a_file_of_no_known_folder_keeps_later_frames_of_all_folders_of_its_frame_out():
    frames = FramesInHand()
    begun(frames, 0, "a", "b").release(failed=True, folder="elsewhere")
    begun(frames, 1, "a", "b", "c").release()
    assert frames.whole() == [(frames.whole()[0][0], "c")]
    assert [frames.lacks(folder) for folder in "abc"] == [True, True, False]


def test_a_frame_at_which_a_writer_failed_counts_once_a_later_one_or_the_run_is_whole():
    frames = FramesInHand()
    for number in range(4):
        frame = frames.begin(number)
        for folder in "ab":
            frame.expect(folder)
            if folder == "b" or number in (0, 2):
                frame.arrive(folder)
        frame.release()
        assert numbers(frames, "b") == [*range(number + 1)]
        assert numbers(frames, "a") == [[0], [0], [0, 1, 2], [0, 1, 2]][number]
    assert [frames.lacks(folder) for folder in "ab"] == [True, False]
    frames.accept_failed()
    assert numbers(frames, "a") == [0, 1, 2, 3]
    assert not frames.lacks("a")


def test_a_frame_that_is_taken_back_is_none():
    frames = FramesInHand()
    begun(frames, 0, "a").take_back()
    frame = begun(frames, 0, "a")
    frame.release()
    assert frames.whole() == [(frame, "a")]


def test_a_failed_frame_of_a_writer_without_a_folder_keeps_nothing_out():
    frames = FramesInHand()
    begun(frames, 0).release(failed=True)
    frame = begun(frames, 1, "a")
    frame.release()
    assert frames.whole() == [(frame, "a")]
    assert not frames.lacks("a")
