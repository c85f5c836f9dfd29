"""What of the paper can be made here: functions only."""

# the paper's tables and figures -> what must be there for them besides the selectors and the sweep
PAPER = {
    "<tables>/seedvar.tex": [],
    "<tables>/freedom.tex": [],
    "<tables>/ga_vs_learned.tex": [held_out_problems],
    "<tables>/time_quality.tex": [held_out_scenes],
    "<tables>/crosscapture.tex": [rooms],
    "<tables>/objectcentric.tex": [object_scenes],
    "<tables>/feature_sweep.tex": [lambda: trial_scenes("feature_sweep")],
    "<tables>/scorer_arch.tex": [lambda: trial_scenes("scorer_arch")],
    "<tables>/poses.tex": [],
    "<tables>/pose_sources.tex": [posed_twice],
    "<tables>/transfer.tex": [held_out_scenes, compared, compared_everywhere],
    "<tables>/reconchoice.tex": [held_out_scenes, compared, compared_everywhere],
    "<figures>/pose_noise.pdf": [],
    "<figures>/saturation.pdf": [held_out_scenes],
    "<figures>/training.pdf": [],
    "<figures>/pipeline.pdf": [],
    "<figures>/teaser.pdf": [],
    "<figures>/real_world.pdf": [rooms],
    **{f"<figures>/qualitative_{dataset}.pdf": [] for dataset in labels()},
}


@cache
def papers():
    """What of `PAPER` can be made here, and lines that say what cannot, and why."""
    made, said = [], []
    for path, needs in PAPER.items():
        try:
            for need in needs:
                need()
            made.append(path)
        except Refusal as error:
            reason = str(error).removeprefix("config: ").splitlines()[0]
            said.append(f"  not made: {path.rsplit('/')[-1]}: {reason}")
    return made, said


@cache
def of_the_paper():
    """What of `PAPER` can be made here; what cannot, and why, is said once."""
    made, said = papers()
    if said:
        head = f"paper: {len(made)} of {len(PAPER)} tables and figures can be made"
        print("\n".join([head, *said]), file=sys.stderr)
    return made
