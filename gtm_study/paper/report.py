"""The results of a study as tables beside the paper's, for Markdown and for the page."""

from collections.abc import Callable, Mapping
from statistics import median
from typing import Any

from gtm_study.paper import published, sensitivity_report
from gtm_study.tables import Section, Table, markdown, short

Row = tuple[str, str, str]


def study_report(results: dict[str, Any]) -> str:
    """The results of all stages that are finished, as Markdown."""
    return markdown(study_sections(results))


def study_sections(results: Mapping[str, Any]) -> list[Section]:
    """The results of all stages that are finished."""
    sections = [Section("Results", 1, (*_quantities(results), *_models(results)))]
    if "sensitivity" in results:
        found = results["sensitivity"]
        sections += sensitivity_report.sensitivity_sections(found, found["failures"])
    return sections


def _quantities(results: Mapping[str, Any]) -> tuple[str | Table, ...]:
    rows = [row for name, describe in _ROWS.items() if name in results for row in describe(results[name])]
    if not rows:
        return ()
    return (
        Table(("quantity", "here", "paper"), rows, "Results beside the paper's"),
        "The paper counts cases of which some have no steady manoeuvre inside its own limits; errors are mean squares "
        "of speeds scaled to 0..1.",
    )


def _envelope_rows(envelopes: dict[str, Any]) -> list[Row]:
    return [
        ("Lattice cases", str(envelopes["cases"]), "1232 possible (Table 7)"),
        ("of them with an envelope", str(envelopes["feasible"]), f"{published.FEASIBLE_CASES} (sections III-C, III-E)"),
    ]


def _network_rows(networks: dict[str, Any]) -> list[Row]:
    mse = networks["mse_independent"]
    return [
        (f"Best of {len(mse)} networks, MSE on the independent test", short(min(mse)), short(published.MSE_ANN[6])),
        (f"Median of {len(mse)} networks, the same", short(median(mse)), "about 1e-4 (Fig. 10)"),
        ("R, independent test", f"{networks['speeds']['r_independent']:.5f}", "close to 1 (Fig. 12)"),
    ]


def _trim_rows(trims: dict[str, Any]) -> list[Row]:
    return [
        ("Trims over the FMU and in the core: same verdict", f"{trims['same_verdict']} of {trims['trims']}", "-"),
        ("their largest difference, of an unknown's scale", short(trims["largest_difference"]), "-"),
        ("Stable of the feasible trims", f"{trims['stable']} of {trims['feasible']}", "-"),
        ("Uncontrollable of them", str(trims["uncontrollable"]), "ignored (Fig. 8)"),
    ]


def _fmu_rows(surrogate: dict[str, Any]) -> list[Row]:
    return [("Surrogate FMU against its thrust map, largest", f"{short(surrogate['largest_difference_kt'])} kn", "-")]


_ROWS: dict[str, Callable[[dict[str, Any]], list[Row]]] = {
    "lattice": _envelope_rows,
    "networks": _network_rows,
    "trims": _trim_rows,
    "surrogate-fmu": _fmu_rows,
}


def _models(results: Mapping[str, Any]) -> tuple[str | Table, ...]:
    names = {"surrogate-fmu": "thrust map (GtmSurrogate.fmu)", "networks": "the paper's networks"}
    models = {name: results[stage]["off_lattice"] for stage, name in names.items() if stage in results}
    return _shipped(models) if models else ()


def _shipped(models: dict[str, dict[str, Any]]) -> tuple[str | Table, ...]:
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
        f"networks, trained on the lattice. On {cases} random cases off the lattice:",
        Table(heads, rows, f"Errors on {cases} random cases off the lattice"),
    )
