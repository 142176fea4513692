"""A run that tells the journals of its frames: none is left out that a later one follows, whatever ends it between."""

import pytest

from tests.writers.journal.test_folders import recipe
from usdsdg.errors import OutputNotWritable
from usdsdg.session import session
from usdsdg.writers.journal import journal
from usdsdg.writers.journal.earlier_run import Mode
from usdsdg.writers.journal.folders import DatasetFolder
from usdsdg.writers.journal.run import get_run


@pytest.fixture
def run():
    session.restart()
    found = session.current().run
    found.begin(recipe(), Mode.NEW, None)
    yield found
    found.release()
    session.restart()


def hand(run, number, *folders):
    """Let a frame be whole that has a file in each folder."""
    frame = run.hand(number)
    for folder in folders:
        (folder / f"{number}.txt").write_text("text")
        frame.note(str(folder), f"{number}.txt", (4, "0"))
    frame.release()


def failing(error, name, monkeypatch, meanwhile=lambda: None):
    """Let the next append to the journal of a folder of this name fail; meanwhile: what the capture does then."""
    append = DatasetFolder.append

    def fail_once(folder, frames):
        if folder.path.name == name:
            monkeypatch.setattr(DatasetFolder, "append", append)
            meanwhile()
            get_run().is_due()
            raise error
        append(folder, frames)

    monkeypatch.setattr(DatasetFolder, "append", fail_once)


def two_folders(run, tmp_path):
    folders = tmp_path / "a", tmp_path / "b"
    for each in folders:
        run.claim(str(each))
    return folders


def listed(folder):
    found = journal.read(folder / ".usdsdg/journal.jsonl")
    return sorted(found.frames), found.is_complete


@pytest.mark.parametrize("name", ["a", "b"])
def test_a_journal_that_could_not_be_told_of_a_frame_ends_before_it_and_others_do_not(run, tmp_path, monkeypatch, name):
    a, b = two_folders(run, tmp_path)
    hand(run, 0, a, b)
    run.append()
    hand(run, 1, a, b)
    failing(OutputNotWritable("the disk failed"), name, monkeypatch, meanwhile=lambda: hand(run, 2, a, b))
    with pytest.raises(OutputNotWritable, match="the disk failed"):
        run.append()
    hand(run, 3, a, b)
    run.close(complete=True)
    failed, other = (a, b) if name == "a" else (b, a)
    assert listed(failed) == ([0], False)
    assert listed(other) == ([0, 1, 2, 3], True)


@pytest.mark.parametrize("name", ["a", "b"])
def test_frames_that_ctrl_c_kept_from_a_journal_are_told_with_the_next_ones(run, tmp_path, monkeypatch, name):
    a, b = two_folders(run, tmp_path)
    hand(run, 0, a, b)
    failing(KeyboardInterrupt(), name, monkeypatch)
    with pytest.raises(KeyboardInterrupt):
        run.append()
    hand(run, 1, a, b)
    run.close(complete=False)
    assert listed(a) == listed(b) == ([0, 1], False)


def test_what_belongs_to_no_frame_is_told_once_the_journal_can_be_written(run, tmp_path, monkeypatch):
    a, _ = two_folders(run, tmp_path)
    (a / "all.txt").write_text("text")
    run.note(str(a), "all.txt", (4, "0"), None)
    hand(run, 0, a)
    with monkeypatch.context() as patched:
        patched.setattr(journal.Journal, "append", lambda *_, **__: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            run.append()
    run.close(complete=True)
    assert "all.txt" in journal.read(a / ".usdsdg/journal.jsonl").shared


def test_a_failure_of_one_folder_leaves_others_closed(run, tmp_path, monkeypatch):
    a, b = two_folders(run, tmp_path)
    hand(run, 0, a, b)
    run.append()
    failing(OutputNotWritable("the disk failed"), "a", monkeypatch)
    with pytest.raises(OutputNotWritable, match="the disk failed"):
        run.close(complete=True)
    assert listed(a) == ([0], False)
    assert listed(b) == ([0], True)


def test_a_complete_dataset_stays_so_when_going_on_is_interrupted(run, tmp_path):
    a, _ = two_folders(run, tmp_path)
    hand(run, 0, a)
    run.close(complete=True)
    before = (a / ".usdsdg/journal.jsonl").read_bytes()
    session.restart()
    again = session.current().run
    again.begin(recipe(), Mode.RESUME, None)
    again.claim(str(a))
    again.close(complete=False)
    assert (a / ".usdsdg/journal.jsonl").read_bytes() == before
