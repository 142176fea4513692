"""Progress in notebooks: what is displayed in a cell, at which times."""

import sys
from types import SimpleNamespace

import pytest

from usdsdg.session import progress
from usdsdg.session.reporters import notebook_progress


class Notebook:
    """A notebook whose time and cells the test sets; `shown` has what each display shows now."""

    def __init__(self, monkeypatch):
        self.now, self.shown, self.updates = 0.0, [], 0
        self.shell = SimpleNamespace(kernel=object(), execution_count=1)
        modules = {
            "IPython": SimpleNamespace(get_ipython=lambda: self.shell),
            "IPython.display": SimpleNamespace(HTML=str, display=self._display),
        }
        for name, module in modules.items():
            monkeypatch.setitem(sys.modules, name, module)
        monkeypatch.setattr(notebook_progress.time, "monotonic", lambda: self.now)

    def _display(self, html, display_id):
        place = len(self.shown)
        self.shown.append(html)
        return SimpleNamespace(update=lambda html: self._update(place, html))

    def _update(self, place, html):
        self.shown[place] = html
        self.updates += 1


@pytest.fixture
def notebook(monkeypatch):
    return Notebook(monkeypatch)


def test_a_notebook_has_bars_and_a_terminal_lines(notebook, monkeypatch):
    monkeypatch.delenv(progress.VARIABLE, raising=False)
    assert isinstance(progress.reporter_of_library(), notebook_progress.NotebookReporter)
    notebook.shell.kernel = None
    assert isinstance(progress.reporter_of_library(), progress.LineReporter)
    monkeypatch.setenv(progress.VARIABLE, "off")
    assert isinstance(progress.reporter_of_library(), progress.SilentReporter)


def test_a_long_task_shows_rate_and_time_left(notebook):
    reporter = notebook_progress.NotebookReporter(progress.described)
    for done in range(21):
        reporter("frames <captured>", done, 40)
        notebook.now += 0.5
    (html,) = notebook.shown
    assert 'value="20" max="40"' in html
    assert "frames &lt;captured&gt;: 20/40, 2.0/s, 10 s left" in html


def test_short_tasks_are_not_shown_and_updates_are_few(notebook):
    reporter = notebook_progress.NotebookReporter(progress.described)
    for done in range(10):
        reporter("short", done, 9)
    assert notebook.shown == []
    for done in range(1001):
        reporter("long", done, 1000)
        notebook.now += 0.01
    assert len(notebook.shown) == 1
    assert notebook.updates <= 9.0 / notebook_progress.UPDATE_SECONDS + 2
    assert "1000/1000" in notebook.shown[0]


def test_each_cell_has_an_output_of_its_own(notebook):
    reporter = notebook_progress.NotebookReporter(progress.described)
    reporter.say("first")
    reporter.say("second")
    notebook.shell.execution_count = 2
    reporter.say("third")
    assert ["first" in html for html in notebook.shown] == [True, False]
    assert "second" in notebook.shown[0]
    assert "third" in notebook.shown[1]
