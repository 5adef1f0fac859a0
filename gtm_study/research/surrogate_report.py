"""The measured surrogates as Markdown tables."""

from collections.abc import Mapping
from typing import Any

from gtm_study.tables import markdown_table, short

_HEADS = (
    "model",
    "searches",
    "MSE restrictions",
    "MSE jams",
    "95 %, kn",
    "99 %, kn",
    "largest, kn",
    "verdict right",
    "fit, s",
)

_SHIPPED_HEADS = ("model", *_HEADS[2:-1], "95 % intervals hold")
SHIPPED, SHIPPED_FURTHER = "package", "package, further cases"
"""Parts of the results: the surrogates of the package on the test set, and on cases that nothing was chosen by."""


def surrogates_report(results: Mapping[str, Any]) -> str:
    """Tables of all models of a failed rudder, of the curves, and of other failures, as far as there are results."""
    text = "# Surrogates off the lattice\n\n"
    if models := results.get("models"):
        ordered = sorted(models.items(), key=lambda item: -item[1]["all"]["mse"])
        rows = [(name, *_cells(model), f"{model['fit_s']:.1f}") for name, model in ordered]
        text += f"{markdown_table(_HEADS, rows)}\n"
    for part, cases in (
        (SHIPPED, "the test set"),
        (SHIPPED_FURTHER, "further cases, used for nothing else"),
    ):
        if shipped := results.get(part):
            rows = [(name, *_measured(model), f"{model['inside_95']:.1%}") for name, model in shipped.items()]
            text += f"## Those of the package, on {cases}\n\n{markdown_table(_SHIPPED_HEADS, rows)}\n"
    if curves := results.get("curves"):
        rows = [(name, *_cells(point), "-") for name, points in curves.items() for point in points]
        text += f"## Error by the number of searches\n\n{markdown_table(_HEADS, rows)}\n"
    if thrust_map := (models or {}).get("thrust map"):
        text += _warnings(thrust_map)
    if others := results.get("other failures"):
        heads = ("failure", "inputs", "model", "MSE", "95 %, kn", "99 %, kn", "largest, kn", "verdict right", "fit, s")
        rows = [
            (failure, str(model["inputs"]), name, *_errors(model), f"{model['fit_s']:.1f}")
            for failure, models_ in others.items()
            for name, model in models_.items()
        ]
        text += f"## Other failures\n\n{markdown_table(heads, rows)}"
    if curves := results.get("trim map"):
        heads = ("failed", "trims", "MSE", "95 %, kn", "99 %, kn", "largest, kn", "verdict right", "us a case", "kB")
        rows = [
            (failure, str(p["trims"]), *_errors(p), f"{p['us']:.0f}", f"{p['bytes'] / 1000:.0f}")
            for failure, points in curves.items()
            for p in points
        ]
        text += f"\n## The trim map by the number of its trims\n\n{markdown_table(heads, rows)}"
    return text


def _cells(model: Mapping[str, Any]) -> tuple[str, ...]:
    return (str(model["searches"]), *_measured(model))


def _measured(model: Mapping[str, Any]) -> tuple[str, ...]:
    parts = (short(model[part]["mse"], 2) if part in model else "-" for part in ("restrictions", "jams"))
    return (*parts, *_errors(model["all"])[1:])


def _errors(scores: Mapping[str, Any]) -> tuple[str, ...]:
    errors = (scores[name] for name in ("percentile_95_kt", "percentile_99_kt", "largest_kt"))
    return (short(scores["mse"], 2), *(f"{error:.2f}" for error in errors), f"{scores['same_verdict']:.2%}")


def _warnings(thrust_map: Mapping[str, Any]) -> str:
    whole = thrust_map["all"]
    return (
        f"The thrust map's 95 % intervals hold {thrust_map['inside_95']:.1%} of the speeds. It flags "
        f"{thrust_map['folds']} of {whole['cases']} cases as folds, {thrust_map['wrong_verdicts_flagged']} of its "
        f"{whole['wrong_verdicts']} wrong verdicts among them. Of the 20 largest errors "
        f"{thrust_map['worst_20_inside_95_or_fold']} are flagged or inside their interval.\n\n"
    )
