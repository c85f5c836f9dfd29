"""What tests of requests share."""

import pytest
from selection_problems import around
from small_captures import ring


@pytest.fixture
def circle():
    return around(ring(24))
