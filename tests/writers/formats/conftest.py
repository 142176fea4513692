"""A frame that the tests of a format write, and its classes."""

import pytest

from tests.annotators.ray_caster import make_frame
from tests.annotators.scenes import street
from usdsdg.session.session import current


@pytest.fixture(scope="module")
def frame():
    """The street, with all classes."""
    return make_frame(street(), (64, 48), filters=["class:*"])


@pytest.fixture
def classes_of_the_frame(frame):
    """The frame is shared by the tests, the class table is not."""
    current().class_tables.of("class:*").add(frame.selection("class:*").labels)
