"""Tables of the features and of the scorers that the paper tried (Appendix A.1 and D.1)."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from fsel.core.files import File, Files, read_table, write_text
from fsel.evaluation.latex import difference, made_by, plain_table, tex
from fsel.evaluation.summary import write_csv
from fsel.experiments.paper.ablation.extras import EXTRAS
from fsel.experiments.scheme import GAP, Scenes, against, cells_of
from fsel.features.columns import FEATURES

OURS = "less_is_more"  # the scorer that others are compared with
VALIDATION = "validation"  # all scenes together, whatever their dataset
SYMBOLS = {
    "d_min_o": r"$d_{\min}^{\mathcal{O}}$",
    "d_mean_o": r"$d_{\mathrm{mean}}^{\mathcal{O}}$",
    "d_p25_o": r"$d_{25}^{\mathcal{O}}$",
    "gamma_min_o": r"$\gamma_{\min}^{\mathcal{O}}$",
    "gamma_mean_o": r"$\gamma_{\mathrm{mean}}^{\mathcal{O}}$",
    "rho_max_o": r"$\rho_{\max}^{\mathcal{O}}$",
    "rho_mean_o": r"$\rho_{\mathrm{mean}}^{\mathcal{O}}$",
    "rho_std_o": r"$\sigma_{\rho}$",
    "tau_tri": r"$\tau_{\mathrm{tri}}$",
    "alpha_mean": r"$\alpha_{\mathrm{mean}}$",
    "b_perp": r"$b_{\perp}$",
    "b_par": r"$b_{\parallel}$",
    "c_vis": r"$c_{\mathrm{vis}}$",
    "d_min_s": "$d_{\\min}^{S}$",
    "gamma_min_s": r"$\gamma_{\min}^{S}$",
    "rho_max_s": r"$\rho_{\max}^{S}$",
    "phi_nov": r"$\phi_{\mathrm{nov}}$",
    "sharpness": r"$\kappa_{\mathrm{sharp}}$",
}
MARK = r"$\bullet$"


def feature_sweep(
    evaluations: Files,
    trials: Files,
    table: File,
    numbers: File,
    *,
    scenes: Scenes,
    cases: Mapping[str, Mapping],
    facts: Mapping,
) -> None:
    """Tabulate PSNR of every feature configuration minus the first's (paper, "Tested features");
    `cases` maps the name of each of `trials` to its `shown` and `added`, in order."""
    every, reference = dict(zip(cases, trials, strict=True)), next(iter(cases))
    result = compare_trials(cells_of(scenes, evaluations, ["psnr"], facts), every, reference)
    write_csv(result, numbers)
    text = (
        r"\textbf{Tested features.} Each row is one feature configuration: a mark means that the "
        "feature is available to the network, a blank that its column is zeroed (width and "
        "parameter count are unchanged); an extra group takes columns of relative geometry that "
        "are blank, rank-normalized ones those of the distances and angles that they encode. "
        f"{_protocol(result, reference, facts)} Rows are in the paper's order."
    )
    head = [r"\#", *(SYMBOLS[name] for name in FEATURES), "extra", r"$\Delta$PSNR (dB)"]
    rows = []
    for name, change in zip(result["method"], _changes(result, reference), strict=True):
        marks = [MARK if feature in cases[name]["shown"] else "" for feature in FEATURES]
        added = cases[name]["added"]
        rows.append([name, *marks, "" if added is None else EXTRAS[added].label, change])
    groups = [
        ("relation to the optimization views", 13),
        ("relation to the selected frames", 4),
        ("quality", 1),
    ]
    columns = "r" + "c" * len(FEATURES) + "|l|r"
    label = "tab:sppfeaturesweep"
    made = plain_table(head, rows, caption=text, label=label, columns=columns, groups=groups)
    write_text(made, table)


def scorer_arch(
    evaluations: Files,
    trials: Files,
    table: File,
    numbers: File,
    *,
    scenes: Scenes,
    labels: Mapping[str, str],
    facts: Mapping,
) -> None:
    """Tabulate PSNR of every scorer minus ours (paper, "Scorer-architecture comparison")."""
    every = dict(zip(labels, trials, strict=True))
    result = compare_trials(cells_of(scenes, evaluations, ["psnr"], facts), every, OURS)
    write_csv(result, numbers)
    text = (
        r"\textbf{Scorer architectures.} All are trained by the same loop on the same "
        f"trajectories and features. {_protocol(result, OURS, facts)} Rows are in the paper's "
        "order."
    )
    rows = [
        [tex(labels[row.method]), f"{row.parameters:,}", change]
        for row, change in zip(result.itertuples(), _changes(result, OURS), strict=True)
    ]
    head = ["Scorer", "Parameters", r"$\Delta$PSNR (dB) $\uparrow$"]
    write_text(plain_table(head, rows, caption=text, label="tab:scorer_arch"), table)


def compare_trials(cells: pd.DataFrame, trials: Mapping[str, File], reference: str) -> pd.DataFrame:
    """Return the paired differences of every trial to a reference, NaN for the reference itself."""
    result = against(cells.assign(dataset=VALIDATION), reference)
    result["draws"] = cells.groupby("method")["draw"].nunique()
    fitted = ["parameters", "loss", "agreement"]
    for name, path in trials.items():
        made = read_table(path)
        result.loc[name, fitted] = made[fitted].mean()
        result.loc[name, "seeds"] = made["seed"].nunique()
    result = result.loc[list(trials)].astype({"parameters": int, "seeds": int})
    order = ["k", "mean", *GAP, *fitted, "seeds", "draws", "n"]
    return result[order].rename_axis("method").reset_index()


def _changes(result: pd.DataFrame, reference: str) -> list[str]:
    gaps = zip(result["method"], result[GAP].to_numpy(), strict=True)
    return ["$0$" if name == reference else difference(*gap) for name, gap in gaps]


def _protocol(result: pd.DataFrame, reference: str, facts: Mapping) -> str:
    """Describe what was compared, how, and on what, in LaTeX."""
    base = result[result["method"] == reference].iloc[0]
    sure = int(((result["difference_low"] > 0) | (result["difference_high"] < 0)).sum())
    return (
        rf"PSNR at $K{{=}}{base['k']}$ on {base['n']} validation scenes, {base['draws']} target "
        f"draws each, mean of {base['seeds']} training seeds ({facts['epochs']} passes), minus "
        f"that of the scorer marked $0$ (${base['mean']:.2f}$\\,dB). In brackets: paired 95\\% "
        "intervals over scenes and draws, each for its row alone; bold where they exclude zero "
        f"(${sure}$ of ${len(result) - 1}$). {made_by(facts)}"
    )
