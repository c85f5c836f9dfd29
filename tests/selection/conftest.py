"""What tests of requests share."""

import pytest
import small_captures
from selection_problems import around


@pytest.fixture
def circle():
    return around(small_captures.ring(24))


@pytest.fixture
def ring(tmp_path):
    small_captures.write_ring(tmp_path / "ring", frames=24)
    return tmp_path / "ring"
