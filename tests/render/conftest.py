"""Warnings speak once a process; every test here starts with none spoken."""

import pytest

from usdsdg import errors


@pytest.fixture(autouse=True)
def fresh_warnings():
    errors.forget_warnings()
