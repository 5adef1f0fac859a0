"""The comparison of networks as tables beside the paper's."""

from statistics import median
from typing import Any

import numpy as np

from gtm_study.paper import published
from gtm_study.paper.protocol_figures import NAMES
from gtm_study.tables import markdown_table, short

PAPER = {
    "bayesian_regularization": f"{published.MSE_ANN[6]:.3g}",
    "levenberg_marquardt": "about 1e-4 (Fig. 10)",
    "local_models": f"{published.MSE_LMN[6]:.3g}",
}


def summary(results: dict[str, Any]) -> dict[str, Any]:
    """What is told of the comparison: least errors by split, data set and number of neurons, and off the lattice."""
    methods = results["networks"] | {"local_models": results["local_models"]}
    data_sets = {
        number: {
            "samples": parts[0]["network"]["samples"],
            **{key: [min(part[key]["mse_independent"]) for part in parts] for key in ("network", "local_models")},
        }
        for number, parts in results["data_sets"].items()
    }
    chosen = [pair for part in results["local_models"] for pair in part["chosen"]]
    return {
        "methods": {
            name: {
                "best": [min(part["mse_independent"]) for part in splits],
                "median": [median(part["mse_independent"]) for part in splits],
                "worst": [max(part["mse_independent"]) for part in splits],
                "best_by_output": [part["mse_by_output"][part["selected"]] for part in splits],
                "off_lattice": [
                    {kind: part["off_lattice"][kind]["mse"] for kind in ("restrictions", "jams")} for part in splits
                ],
                "rounds_of_the_first_split": splits[0]["mse_independent"],
            }
            for name, splits in methods.items()
        },
        "corners": [part["corners"] for part in results["local_models"]],
        "corner_share": [_corner_share(part) for part in results["networks"]["bayesian_regularization"]],
        "hilomot_share": {
            name: float(np.mean([pair[o].startswith("hilomot") for pair in chosen]))
            for o, name in enumerate(("v_min", "v_max"))
        },
        "local_model_sizes": [part["sizes"] for part in results["local_models"]],
        "rounds_with_a_better_network": [
            int(np.sum(np.array(network["mse_independent"]) < np.array(local["mse_independent"])))
            for network, local in zip(
                results["networks"]["bayesian_regularization"], results["local_models"], strict=True
            )
        ],
        "data_sets": data_sets,
        "neurons": {
            str(n): {"median": median(mse), "least": min(mse), "greatest": max(mse)}
            for n, mse in zip(results["neurons"]["neurons"], results["neurons"]["mse_independent"], strict=True)
        },
    }


def _corner_share(part: dict[str, Any]) -> float:
    """Share of the selected network's squared error that the corner cases carry."""
    squares, cases = np.array(part["squared_errors"]).sum(axis=1), [tuple(case) for case in part["cases"]]
    corners = {tuple(case) for case in part["corners"]}
    return float(squares[[case in corners for case in cases]].sum() / squares.sum())


def protocol_report(results: dict[str, Any]) -> str:
    """The tables."""
    methods, splits = results["methods"], range(len(results["corners"]))
    heads = ["method", *(f"split {s + 1}{' (corner)' if results['corners'][s] else ''}" for s in splits)]
    best = [
        [NAMES[name], *map(short, values["best"]), short(median(values["best"])), PAPER[name]]
        for name, values in methods.items()
    ]
    spread = [
        [NAMES[name], *(f"{short(m)} / {short(w)}" for m, w in zip(values["median"], values["worst"], strict=True))]
        for name, values in methods.items()
    ]
    outputs = [
        [NAMES[name], *(f"{short(a)} / {short(b)}" for a, b in values["best_by_output"])]
        for name, values in methods.items()
    ]
    off = [
        [NAMES[name], *(f"{short(part['restrictions'])} / {short(part['jams'])}" for part in values["off_lattice"])]
        for name, values in methods.items()
    ]
    sets = [
        [
            str(number),
            str(values["samples"]),
            *(short(median(values[key])) for key in ("network", "local_models")),
            str(published.TRAINING_SAMPLES[int(number)]),
            short(published.MSE_ANN[int(number)]),
            short(published.MSE_LMN[int(number)]),
        ]
        for number, values in results["data_sets"].items()
    ]
    neurons = [
        [n, *(short(values[key]) for key in ("least", "median", "greatest"))]
        for n, values in results["neurons"].items()
    ]
    corners = "; ".join(
        f"split {s + 1}: {corner[0]:g} ft, {corner[1]:g} deg, rudder jammed at {corner[2]:g} deg, with "
        f"{results['corner_share'][s]:.0%} of the selected network's squared error"
        for s in splits
        for corner in results["corners"][s]
    )
    return "\n".join(
        [
            "# Neural networks and local model networks\n",
            "Mean squared errors of speeds mapped to 0..1 (paper eq. 11). A split is a seed's division of the lattice "
            "into a design part and 10 % independent test data, the same for all methods.\n",
            "## Least error of all rounds on the independent test data (Table 6, Figs. 10, 17-19)\n",
            markdown_table([*heads, "median", "paper"], best),
            f"Corner cases of the lattice among the tests: {corners or 'none'}.\n",
            "Median and worst of the rounds:\n",
            markdown_table(heads, spread),
            "The selected models by output, V_min / V_max:\n",
            markdown_table(heads, outputs),
            "All rounds of the first split (Table 6):\n",
            markdown_table(
                ["round", *(NAMES[name] for name in methods)],
                [
                    [str(j + 1), *map(short, errors)]
                    for j, errors in enumerate(
                        zip(*(values["rounds_of_the_first_split"] for values in methods.values()), strict=True)
                    )
                ],
            ),
            f"Rounds in which the network beats the local models: "
            f"{', '.join(map(str, results['rounds_with_a_better_network']))} of "
            f"{len(methods['local_models']['rounds_of_the_first_split'])} (the paper: all 20). HILOMOT is chosen in "
            f"{results['hilomot_share']['v_max']:.0%} of the rounds for V_max (the paper: all), "
            f"{results['hilomot_share']['v_min']:.0%} for V_min.\n",
            "## The selected models off the lattice, restrictions / jams\n",
            markdown_table(heads, off),
            "## Diminished data sets (Table 14, Fig. 28), median over splits\n",
            markdown_table(
                ["data set", "samples", "network", "local models", "paper: samples", "network", "local models"], sets
            ),
            "The independent test data are those of the whole data set throughout. The paper counts those too.\n",
            "## Hidden neurons (Fig. 41)\n",
            markdown_table(["neurons", "least", "median", "greatest"], neurons),
        ]
    )
