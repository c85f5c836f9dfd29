"""A capture for the commands."""

import pytest
from small_captures import write_ring


@pytest.fixture
def capture(tmp_path):
    folder = tmp_path / "capture"
    write_ring(folder)
    return folder
