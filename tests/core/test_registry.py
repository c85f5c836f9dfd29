"""Registries: names without imports, entries on demand, refusals by name."""

import pytest
from own_python import printed

from fsel.core.registry import Registry

LISTING = """
import sys
from fsel.selectors.baselines import METHODS
from fsel.captures.layouts import LAYOUTS
from fsel.reconstruct import RECONSTRUCTORS

listed = [*METHODS, *LAYOUTS, *RECONSTRUCTORS]
assert "splats" in RECONSTRUCTORS
lazy = {"fsel.selectors.baselines.by_pose", "fsel.captures.layouts.co3d", "fsel.reconstruct.splats"}
print(*lazy & set(sys.modules))
METHODS["fvs"], LAYOUTS["co3d"], RECONSTRUCTORS["splats"]
others = {"fsel.selectors.baselines.by_reconstruction", "fsel.captures.layouts.scannet"}
print(*others & set(sys.modules))
"""


def test_listing_imports_nothing_and_one_entry_not_the_others():
    assert printed(LISTING).split() == []


def test_an_entry_set_by_hand_stands_for_itself_and_goes_again():
    registry = Registry("metric", {"first": "no_such_package:FIRST"})
    registry["second"] = entry = object()
    assert list(registry) == ["first", "second"]
    assert registry["second"] is entry
    del registry["second"]
    assert "second" not in registry


@pytest.mark.parametrize(
    ("name", "said"), [("lessismore", "did you mean 'less_is_more'"), ("theirs", "fsel$")]
)
def test_a_near_name_is_refused_with_the_one_that_was_meant(name, said):
    methods = Registry("method", {"less_is_more": "", "fsel": ""})
    with pytest.raises(ValueError, match=rf"method is '{name}'; allowed: less_is_more, .*{said}"):
        methods.checked(name)
    with pytest.raises(KeyError, match=name):
        methods[name]
