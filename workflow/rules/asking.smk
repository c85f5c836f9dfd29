"""Which scenes' requests are labelled, what learned from them is judged on, and by what: functions only."""

from fsel.experiments.learning.cases import LEARNERS

LESSONS = [
    f"{d}/{s}"
    for d in config["datasets"]
    for s in scenes(d, "train")[: config["learning"]["scenes"]]
]


def labelled_requests():
    """Labels of the requests of every scene that is learned from."""
    learning = config["learning"]
    most, frames = max(learning["budgets"]), config["embedded"]["frames"]
    # targets, a subset, and what comes in the place of a third of it
    needed = max(4, int(0.15 * max(learning["coverages"]) + 0.5)) + most + most // 3
    if frames < needed:
        refuse(
            f"embedded.frames is {frames}, requests of {most} frames need {needed}: targets, a "
            "subset, and what a third of it is exchanged for",
            "raise embedded.frames, or lower learning.budgets",
        )
    return [f"<results>/{scene}/requests.parquet" for scene in LESSONS]


def first_lessons():
    """Numbers of the first labelled scene of every dataset, which learners practise on."""
    names = [scene.split("/")[0] for scene in LESSONS]
    return [names.index(name) for name in dict.fromkeys(names)]


def started_from(wildcards):
    """The networks that a learner goes on from, if any."""
    start = LEARNERS[wildcards.learner].start
    return [] if start is None else [f"<results>/learning/{start}.safetensors"]


def judged_scenes(roles=None):
    """(role, dataset, scene) of every scene with a role that learners are judged on."""
    roles = roles or config["learning"]["roles"]
    found = [(r, d, s) for r in roles for d in config["datasets"] for s in scenes(d, r)]
    if missing := [r for r in roles if r not in {role for role, _, _ in found}]:
        refuse(
            f"no dataset has {missing[0]} scenes, of learning.roles {roles}",
            "give some a number of them, or leave the role out",
        )
    return found


def validation_scenes():
    """The same of validation scenes alone: choices between inputs are made there."""
    return judged_scenes(["validation"])


def judged_datasets(roles=None):
    """Names of the datasets of those scenes, in order."""
    return list(dict.fromkeys(dataset for _, dataset, _ in judged_scenes(roles)))


def first_labelled():
    """dataset/scene of those, whose labels are judged again."""
    return [LESSONS[number] for number in first_lessons()]


@cache
def learning_judges():
    """Name -> section of the first reconstructor, and of the one that judges after it."""
    where = "learning.judge.reconstruction"
    first = config["reconstruction"] | {"as": next(iter(JUDGES))}
    found = judges([first, config["learning"]["judge"]["reconstruction"]], where)
    if workflow.is_main_process:
        check_judges(found, where)
    return found


def second_judge():
    """Name and section of the one that judges after the first."""
    return list(learning_judges().items())[1]


def second_budgets():
    """Budgets whose picks are judged again."""
    asked = config["learning"]["judge"]["budgets"]
    if missing := [k for k in asked if k not in config["budgets"]]:
        refuse(
            f"learning.judge.budgets has {missing}, which are not among budgets {config['budgets']}",
            "nothing is selected for the second judge; picks for the first are taken",
        )
    return asked
