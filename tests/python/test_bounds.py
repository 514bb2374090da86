"""Levels and strengths of limit analysis: the place where bodies begin to stand is closed in by few trials, whatever what is missing looks like before it."""

import math

import pytest
from quoin_tools.limit.bounds import STANDS, closed_in

SHAPES = {  # what is missing, and where it falls to STANDS
    "straight": (lambda x: max(0.0, 1 - x), 1 - STANDS, 10),
    "two mechanisms": (lambda x: max(0.0, 1 - x) + max(0.0, 0.3 - x) * 100, 1 - STANDS, 11),
    "touches": (lambda x: max(0.0, 1 - x) ** 3, 1 - STANDS ** (1 / 3), 35),
    "steep at its end": (lambda x: max(0.0, 1 - x) ** 0.3, 1.0, 35),
    "a step": (lambda x: 5.0 if x < 1 else 0.0, 1.0, 35),
    "flat": (lambda x: math.exp(-40 * x), -math.log(STANDS) / 40, 35),
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("fails, stands, up", [(0.0, 45.0, 1), (0.0, 1.01, 1), (2.0, -45.0, -1)])
def test_closed_in(shape, fails, stands, up):
    """From below and from above, as a strength and a level; no more trials than a third more than halving takes, and far fewer where it is straight."""
    missing, place, most = SHAPES[shape]
    asked = []

    def short_of(value):
        asked.append(value)
        return missing(value if up > 0 else 2 - value)

    low, high = closed_in(short_of, fails, stands, 4.5e-6)
    place = place if up > 0 else 2 - place
    assert min(low, high) - 1e-9 <= place <= max(low, high) + 1e-9 and abs(high - low) <= 4.5e-6
    assert missing(low if up > 0 else 2 - low) > STANDS >= missing(high if up > 0 else 2 - high)
    assert len(asked) <= most
