"""Every name of Replicator exists here with the signature of the table, or is listed in GAPS.md with the reason."""

import inspect

import pytest

from tests.contracts import gaps, mirror
from tests.contracts.mirror import parsed, signature_faults


def test_missing_and_different_names_are_listed():
    known = {name for section in (gaps.MISSING, gaps.DIFFERENT, gaps.UNBUILT) for name in gaps.listed(section)}
    unlisted = {path: what for path, what in mirror.differences().items() if path not in known}
    assert not unlisted


def test_names_listed_as_missing_are_missing():
    found = mirror.differences()
    assert [path for path in gaps.listed(gaps.MISSING) if found.get(path) not in (mirror.MISSING, mirror.REFUSES)] == []


def test_names_listed_as_different_exist_and_differ():
    found = mirror.differences()
    stale = [path for path in gaps.listed(gaps.DIFFERENT) if found.get(path, mirror.MISSING) == mirror.MISSING]
    assert stale == []


def test_listed_names_are_listed_once_and_are_in_the_table():
    every = [name for section in (gaps.MISSING, gaps.DIFFERENT, gaps.UNBUILT) for name in gaps.listed(section)]
    assert len(every) == len(set(every))
    assert set(every) <= set(mirror.names())


def test_unused_arguments_are_named_in_the_docstring():
    silent = {path: mirror.unread(name) for path, name in mirror.names().items() if name.signature is not None}
    assert {path: arguments for path, arguments in silent.items() if arguments} == {}


def test_few_names_are_missing_on_purpose():
    assert len(gaps.listed(gaps.MISSING)) <= 0.03 * len(mirror.names())


@pytest.mark.parametrize(
    ("theirs", "ours", "fault"),
    [
        ("(a, b=1)", "(a, b=1.0, *, c=None)", ""),
        ("(a, b=1)", "(a, b=2)", "b is 2, not is 1"),
        ("(a, b=1)", "(b=1, a=2)", "a is not parameter 0"),
        ("(a, b=1)", "(a)", "has no parameter b"),
        ("(a, b=1)", "(a, b)", "b must be given, not is 1"),
        ("(a, b=1)", "(a, b=True)", "b is True, not is 1"),
        ("(a)", "(a, c=1)", "c can be given by position"),
        ("(a)", "(a, *, c)", "c must be given"),
        ("(a)", "(a=None)", ""),
        ("(a, **_more)", "(a)", ""),
        ("(a, **_more)", "(a, **options)", ""),
        ("(a)", "(a, **options)", "takes **arguments"),
        ("(a, **kw)", "(a)", "takes no **arguments"),
        ("(a, **kw)", "(a, **options)", ""),
        ("(_cb, b=1)", "(callback, b=1)", ""),
        ("(_cb)", "()", "has no parameter"),
        ("(a, *, b=..., c=1)", "(c=1, a=1)", "a is not parameter 0"),
        ("(a, *, b=..., c=1)", "(a, c=1, b=2)", ""),
        ("(a, *, b=..., c=1)", "(a, c=1)", "has no parameter b"),
        ("(a=(None,)*3)", "(a=(None, None, None))", ""),
        ("(a=(0, 0))", "(a=(0.0, 1.0))", "a is (0.0, 1.0), not is (0, 0)"),
    ],
)
def test_signatures_are_compared_as_callers_see_them(theirs, ours, fault):
    found = "; ".join(signature_faults(parsed(theirs), parsed(ours)))
    assert fault in found if fault else found == ""


def test_a_function_that_only_raises_unsupported_counts_as_missing():
    assert mirror.differences()["trigger.on_key_press"] == mirror.REFUSES


def test_the_section_of_names_not_built_yet_is_generated_from_the_table():
    text = "## Missing on purpose\n\n| `trigger.on_key_press` | x | y |\n\n## Not built yet\n\n- `old`: missing\n"
    rewritten = gaps.with_unbuilt(text)
    on_purpose = gaps.listed(gaps.MISSING, rewritten)
    assert on_purpose == ["trigger.on_key_press"]
    assert set(gaps.listed(gaps.UNBUILT, rewritten)) == set(mirror.differences()) - set(on_purpose)
    assert gaps.with_unbuilt(rewritten) == rewritten


def test_the_table_is_parsed_as_written():
    names = mirror.names()
    on_frame = names["trigger.on_frame"]
    assert (on_frame.section, on_frame.returns, on_frame.version) == ("a.7", "item", "1.12")
    assert on_frame.signature.parameters["name"].default == "on_frame"
    assert [version for version, _ in on_frame.more] == ["4.2"]
    assert names["functional.create.capsule"].version == "6.0"
    assert names["orchestrator.Status.STEPPED"].value == "8"
    assert names["create.tiled_sensor"].signature is None
    assert names["distribution.uniform"].signature.parameters["lower"].default is inspect.Parameter.empty
