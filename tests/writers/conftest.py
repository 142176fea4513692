import pytest

from usdsdg import writers


@pytest.fixture(autouse=True)
def detached():
    """No test leaves a writer attached."""
    yield
    writers.detach_all()
