"""Warnings are shown once a process; every test here starts with none shown."""

import pytest

from usdsdg import errors


@pytest.fixture(autouse=True)
def fresh_warnings():
    errors.forget_warnings()
