"""`python -m tests`: how it starts the checks."""

from tests.__main__ import variables


def test_tests_keep_compiled_modules_in_a_folder_where_python_may_not_keep_them():
    given = {"HOME": "/home", "PYTHONDONTWRITEBYTECODE": "1"}
    assert variables(given, "/tmp/compiled") == {"HOME": "/home", "PYTHONPYCACHEPREFIX": "/tmp/compiled"}
    assert variables({"HOME": "/home"}, "/tmp/compiled") == {"HOME": "/home"}
