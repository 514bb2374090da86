"""What all Python tests have in common.

Tests with the mark `alone` run on several ranks and take turns (tests/verification/turns.py). Those with the mark `long` are left
out of the first lane of checks (QUOIN_SHORT=1, as tools/test.sh sets it)."""

import os

import pytest
from turns import turn


def pytest_collection_modifyitems(items):
    if os.environ.get("QUOIN_SHORT"):
        for item in items:
            if item.get_closest_marker("long"):
                item.add_marker(pytest.mark.skip(reason="long: tools/test.sh --all runs it"))


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_protocol(item):
    if item.get_closest_marker("skip"):
        yield
    else:
        with turn(alone=item.get_closest_marker("alone") is not None):
            yield
