"""The results of a study as a table beside the paper's."""

from statistics import median
from typing import Any

from study.paper import published, sensitivity_report
from study.tables import markdown_table, short

Row = tuple[str, str, str]


def study_report(results: dict[str, Any]) -> str:
    """The results as Markdown."""
    trims, envelopes, networks = results["trims"], results["envelopes"], results["networks"]
    truth, surrogate = results["off_lattice"], results["surrogate_fmu"]
    mse = networks["mse_independent"]
    errors = zip(truth["median_error_kt"], truth["percentile_95_error_kt"], truth["largest_error_kt"], strict=True)
    rows: list[Row] = [
        ("Lattice cases", str(envelopes["cases"]), "1232 possible (Table 7)"),
        ("of them with an envelope", str(envelopes["feasible"]), f"{published.FEASIBLE_CASES} (sections III-C, III-E)"),
        (f"Best of {len(mse)} networks, MSE on the independent test", short(min(mse)), short(published.MSE_ANN[6])),
        (f"Median of {len(mse)} networks, the same", short(median(mse)), "about 1e-4 (Fig. 10)"),
        ("R, independent test", f"{networks['speeds']['r_independent']:.5f}", "close to 1 (Fig. 12)"),
        (
            f"Its MSE between the lattice's nodes, {truth['compared']} random cases",
            short(truth["mse"]),
            "not studied",
        ),
        ("Feasibility right there", f"{truth['same_verdict']} of {truth['cases']}", "not studied"),
    ]
    for name, (middle, high, largest) in zip(("V_min", "V_max"), errors, strict=True):
        text = f"{middle:.2f} / {high:.2f} / {largest:.2f} kn"
        rows.append((f"Error of {name} there: median / 95 % / largest", text, "not studied"))
    rows += [
        ("Trims over the FMU and in the core: same verdict", f"{trims['same_verdict']} of {trims['trims']}", "-"),
        ("their largest difference, of an unknown's scale", short(trims["largest_difference"]), "-"),
        ("Stable of the feasible trims", f"{trims['stable']} of {trims['feasible']}", "-"),
        ("Uncontrollable of them", str(trims["uncontrollable"]), "ignored (Fig. 8)"),
        ("Surrogate FMU against its thrust map, largest", f"{short(surrogate['largest_difference_kt'])} kn", "-"),
    ]
    return (
        "# Results\n\n"
        + markdown_table(("quantity", "here", "paper"), rows)
        + "\n"
        + _shipped(results["off_lattice_test_set"])
        + "\nThe paper counts cases of which some have no steady manoeuvre inside its own limits; errors are mean "
        "squares of speeds scaled to 0..1.\n\n"
        + sensitivity_report.sensitivity_section(results["sensitivity"], results["failures"])
    )


def _shipped(models: dict[str, dict[str, Any]]) -> str:
    """Errors on the package's test set of what the study leaves."""
    rows = []
    for name, scores in models.items():
        whole = scores["all"]
        errors = (f"{whole[key]:.2f}" for key in ("percentile_95_kt", "percentile_99_kt", "largest_kt"))
        rows.append((name, short(whole["mse"]), *errors, f"{whole['same_verdict']:.2%}", f"{scores['inside_95']:.1%}"))
    heads = ("model", "MSE", "95 %, kn", "99 %, kn", "largest, kn", "verdict right", "95 % intervals hold")
    cases = next(iter(models.values()))["all"]["cases"]
    return (
        "`GtmSurrogate.fmu` carries the thrust map; `rudder_speeds.json` and `rudder_throttle.json` are the paper's "
        f"networks, trained on the lattice. On {cases} random cases off the lattice:\n\n" + markdown_table(heads, rows)
    )
