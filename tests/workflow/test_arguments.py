"""Every rule has what its function takes, and nothing more."""

import os
from types import SimpleNamespace

import pytest
from dry_runs import ROOT
from snakemake.api import SnakemakeApi
from snakemake.iocontainers import Namedlist
from snakemake.settings.types import ConfigSettings, OutputSettings, Quietness, ResourceSettings

from fsel.workflow.functions import function_of
from fsel.workflow.job import arguments


@pytest.fixture(scope="module")
def rules(tmp_path_factory):
    """The rules that the runner runs."""
    config = ConfigSettings(configfiles=[ROOT / "config" / "smoke.yaml"])
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("rules"))
        patch.setattr(os, "environ", os.environ.copy())
        with SnakemakeApi(OutputSettings(quiet={Quietness.ALL})) as api:
            made = api.workflow(ResourceSettings(), config, snakefile=ROOT / "Snakefile")
            found = [rule for rule in made._workflow.rules if rule.script and rule.output]
    assert len(found) > 15
    return found


def handed(rule, several):
    """The rule's object, with values in place of what is known once the wildcards are.

    A function says only when it is called whether it gives one file or several.
    """

    def listed(values):
        found = Namedlist(toclone=["unnamed"] * sum(name is None for name, _ in values._allitems()))
        for name, value in values.items():
            start, many = (
                len(found),
                isinstance(value, list | tuple) or (several and callable(value)),
            )
            found.append(f"folder/{name}")
            found._set_name(name, start, end=len(found) if many else None)
        return found

    params, wildcards = Namedlist(), Namedlist()
    for found, names in ((params, rule.params.keys()), (wildcards, rule.wildcard_names)):
        for name in names:
            found.append("x")
            found._set_name(name, len(found) - 1)
    return SimpleNamespace(
        rule=rule.name,
        threads=1,
        input=listed(rule.input),
        output=listed(rule.output),
        params=params,
        wildcards=wildcards,
    )


def test_every_rule_has_what_its_function_takes(rules):
    for rule in rules:
        refused = []
        for several in (False, True):
            try:
                arguments(handed(rule, several), function_of(rule.name))
            except TypeError as error:
                refused.append(str(error))
        assert len(refused) < 2, refused


def test_a_rule_is_named_as_its_function_or_a_variant_of_it(rules):
    names = {rule.name for rule in rules}
    assert {"train", "train_no_appearance", "features_labelled"} <= names
    for rule in rules:
        function = function_of(rule.name)
        verbs = [name.split("_")[0] for name in (rule.name, function.__name__)]
        assert rule.name in (function.__name__, "teaser") or verbs[0] == verbs[1], rule.name
