"""The twin computes in float64; the other tests keep torch's own default."""

import pytest
import torch


@pytest.fixture(autouse=True)
def in_float64():
    before = torch.get_default_dtype()
    torch.set_default_dtype(torch.float64)
    yield
    torch.set_default_dtype(before)
