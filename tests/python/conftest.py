"""Tests take turns (tests/verification/turns.py): those with the mark `alone` run on several ranks."""

import pytest
from turns import turn


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_protocol(item):
    with turn(alone=item.get_closest_marker("alone") is not None):
        yield
