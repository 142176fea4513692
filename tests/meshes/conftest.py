"""The cache of converted mesh files is a test's own where a module asks for it."""

import pytest


@pytest.fixture
def own_cache(tmp_path, monkeypatch):
    """Convert mesh files anew."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
