"""What the trainings say to the paper's figures and tables of networks and local model networks."""

from collections.abc import Callable, Sequence
from statistics import mean, median
from typing import Any

from gtm_study.paper import published
from gtm_study.paper.counterpart import Finding, Results, Verdict
from gtm_study.paper.envelope_findings import FALLS_KT, agreed
from gtm_study.paper.protocol_figures import NAMES
from gtm_study.tables import short

FACTOR = 2.0
"""Errors by less than this factor apart are alike: the division of the data moves them by more."""
OUTLIER = 3.0
"""So many times the median is a larger error."""
SPLIT = "Which tenth of the data is set apart decides more than the method: the stage splits measures it."
NOT_ON_THE_LATTICE = (
    "The paper counts this case to its independent test data, but 25 deg is not among its levels (Table 3): the models "
    "interpolate between jams at 20 and 30 deg."
)


def by_error(ours: float, theirs: float) -> Verdict:
    """Better below the published error, the same up to a factor above it."""
    return "better" if ours < theirs else "same" if ours < FACTOR * theirs else "different"


def _over_splits(results: Results) -> str:
    """What the stage of several splits found, once it is there."""
    if "splits" not in results:
        return SPLIT
    best = results["splits"]["best"]["bayesian_regularization"]
    return (
        f"Which tenth of the data is set apart decides more than the method: over {len(best)} divisions the best "
        f"network's error goes from {short(min(best))} to {short(max(best))}."
    )


def trainings(results: Results) -> Finding:
    """Figure 10 and Table 6: networks with and without regularisation."""
    bayesian, plain = (results[name]["part"]["mse_independent"] for name in ("networks", "levenberg-marquardt"))
    ahead = sum(a < b for a, b in zip(bayesian, plain, strict=True))
    far = {
        name: [j + 1 for j, mse in enumerate(errors) if mse > OUTLIER * median(errors)]
        for name, errors in (("with", bayesian), ("without", plain))
    }
    found = by_error(min(bayesian), published.MSE_ANN[6])
    return Finding(
        f"Best {short(min(bayesian))} with regularisation (network {bayesian.index(min(bayesian)) + 1}) and "
        f"{short(min(plain))} without (network {plain.index(min(plain)) + 1}); regularisation is ahead in {ahead} of "
        f"{len(bayesian)} networks. Errors above {OUTLIER:g} times the median: {len(far['without'])} networks without "
        f"regularisation, {len(far['with'])} with it.",
        found if ahead > len(bayesian) / 2 else "different",
        f"The paper's best is {published.MSE_ANN[6]:.2e}, both about 1e-4, with three far off by early stopping. "
        + _over_splits(results),
    )


def _training(stage: str, method: str) -> Callable[[Results], Finding]:
    def find(results: Results) -> Finding:
        part = results[stage]["part"]
        j = part["selected"]
        own, other = part["mse_training"][j], part["mse_independent"][j]
        return Finding(
            f"Network {j + 1} after {part['epochs'][j]} epochs: {short(own)} on its training data, {short(other)} on "
            "the independent test data.",
            agreed(other < OUTLIER * own),
            f"The paper's is network {published.BEST_NETWORK[method]}, with negligible differences between training "
            "and test. The number follows from random starts. Here the errors differ by a factor of "
            f"{other / own:.1f}.",
        )

    return find


def _regression(stage: str, metrics: Callable[[Results], Any]) -> Callable[[Results], Finding]:
    def find(results: Results) -> Finding:
        found = {name: value for name, value in metrics(results).items() if name.startswith("r_")}
        told = ", ".join(f"{name.removeprefix('r_')} {value:.5f}" for name, value in found.items())
        return Finding(f"R: {told}.", agreed(min(found.values()) > 0.99), "Close to 1 on every part of the data.")

    return find


def _histogram(stage: str, theirs: float) -> Callable[[Results], Finding]:
    def find(results: Results) -> Finding:
        part = results[stage]["part"]
        v_min, v_max = part["mse_by_output"][part["selected"]]
        return Finding(
            f"Root mean square {100 * v_min**0.5:.2f} % of the range of V_min, {100 * v_max**0.5:.2f} % of that of "
            "V_max.",
            by_error(mean((v_min, v_max)), published.MSE_ANN[6]),
            f"The paper's error of {published.MSE_ANN[6]:.2e} is {100 * published.MSE_ANN[6] ** 0.5:.2f} % of the "
            "ranges.",
        )

    return find


bayesian_training = _training("networks", "bayesian_regularization")
plain_training = _training("levenberg-marquardt", "levenberg_marquardt")
bayesian_regression = _regression("networks", lambda results: results["networks"]["speeds"])
plain_regression = _regression("levenberg-marquardt", lambda results: results["levenberg-marquardt"]["metrics"])
bayesian_histogram = _histogram("networks", published.MSE_ANN[6])
plain_histogram = _histogram("levenberg-marquardt", published.MSE_ORDER)


def against_local_models(results: Results) -> Finding:
    """Figure 17: rounds in which the networks are ahead."""
    network, local = (results[name]["part"]["mse_independent"] for name in ("networks", "local-models"))
    wins, rounds = sum(a < b for a, b in zip(network, local, strict=True)), len(network)
    why = f"The paper: all {published.TRAINING_ROUNDS}. Which is ahead changes with the division of the data. "
    if "splits" in results:
        found = results["splits"]
        why += (
            f"Over {len(found['rounds_with_a_better_network'])} divisions the networks are ahead in "
            f"{', '.join(map(str, found['rounds_with_a_better_network']))} of {found['rounds']} rounds each. "
        )
    off = [results[name]["part"]["off_lattice"]["all"]["mse"] for name in ("networks", "local-models")]
    why += f"Off the lattice the selected ones err by {short(off[0])} and {short(off[1])}."
    return Finding(
        f"The networks are ahead in {wins} of {rounds} rounds; best {short(min(network))} and {short(min(local))}.",
        agreed(wins == rounds),
        why,
    )


def _by_output(stage: str, method: str) -> Callable[[Results], Finding]:
    def find(results: Results) -> Finding:
        part = results[stage]["part"]
        v_min, v_max = (median(column) for column in zip(*part["mse_by_output"], strict=True))
        return Finding(
            f"Number {part['selected'] + 1} is best. Medians of the rounds: {short(v_min)} for V_min, {short(v_max)} "
            "for V_max.",
            agreed(v_max > v_min),
            f"The paper's best is number {published.BEST_NETWORK[method]}, which follows from random starts; its "
            "errors of V_max are the larger ones.",
        )

    return find


local_by_output = _by_output("local-models", "local_models")
networks_by_output = _by_output("networks", "bayesian_regularization")


def growth(results: Results) -> Finding:
    """Figures 20-22: how the best local model network of V_max grew."""
    part = results["local-models"]["part"]
    size, chosen = part["sizes"][-1], part["chosen"][part["selected"]][-1]
    share = mean(pair[-1].startswith("hilomot") for pair in part["chosen"])
    return Finding(
        f"{size['models']} models with {size['parameters']} parameters, by {_words(chosen)}. HILOMOT is chosen for "
        f"V_max in {share:.0%} of the rounds.",
        agreed(chosen == "hilomot quadratic"),
        f"The paper's has {published.BEST_GROWTH['models']} models and {published.BEST_GROWTH['parameters']} "
        "parameters, quadratic by HILOMOT, and HILOMOT wins all rounds for V_max. The size follows from when the "
        "validation data stop the growth.",
    )


def _words(chosen: str) -> str:
    algorithm, _, model = chosen.partition(" ")
    return f"{algorithm.upper()} with {model.replace('_', ' ')} models"


def squared_errors(results: Results) -> Finding:
    """Figure 23: errors of V_max case by case."""
    squares = results["local-models"]["squares"]
    local, network = squares["local_models"], squares["bayesian_regularization"]
    worst = sorted(range(len(local)), key=lambda k: -local[k])[:4]
    share = sum(local[k] for k in worst) / sum(local)
    larger = sum(local[k] > network[k] for k in worst)
    return Finding(
        f"{len(local)} cases; the local models' four worst carry {share:.0%} of their squared error, and in {larger} "
        "of them the network is nearer.",
        agreed(share > 0.5 and larger >= 3),
        f"The paper has {published.INDEPENDENT_TEST_CASES} cases, of which some have no steady manoeuvre inside its "
        "limits, and four outliers of the local models.",
    )


def outlier(k: int) -> Callable[[Results], Finding]:
    """Figures 24-27: speeds of the selected models at one of the paper's four cases."""

    def find(results: Results) -> Finding:
        found = results["outliers"]
        exact = found["exact_kt"][k]
        errors = {name: _errors(speeds[k], exact) for name, speeds in found["estimates_kt"].items()}
        local, network = errors[NAMES["local_models"]], errors[NAMES["bayesian_regularization"]]
        far = local[1] < -FALLS_KT and abs(local[1]) > abs(network[1])
        near = max(abs(local[1]), abs(network[1])) < FALLS_KT
        on_lattice = "" if published.OUTLIERS[k][2] % 10.0 == 0.0 else f" {NOT_ON_THE_LATTICE}"
        return Finding(
            f"Exact {exact[0]:.1f} .. {exact[1]:.1f} kn. {_told(errors)}",
            "same" if far else "better" if near else "different",
            (
                "The local models' V_max is far too low, as published."
                if far
                else "The local models trained here do not fail at this case: the paper's outliers are those of one "
                "selection. Here others are worst (stage local-models)."
            )
            + on_lattice,
        )

    return find


def _errors(speeds: Sequence[float], exact: Sequence[float]) -> tuple[float, float]:
    return speeds[0] - exact[0], speeds[1] - exact[1]


def _told(errors: dict[str, tuple[float, float]]) -> str:
    return "; ".join(f"{name}: V_min {a:+.1f} kn, V_max {b:+.1f} kn" for name, (a, b) in errors.items()) + "."


def data_sets(results: Results) -> Finding:
    """Figure 28 and Table 14: errors by data set."""
    least = results["data-sets"]["least"]
    network, local = (
        {int(k): median(values) for k, values in least[key].items()} for key in ("network", "local_models")
    )
    ahead = [k for k in network if network[k] < local[k]]
    small = min((k for k in network if k != 6), key=network.__getitem__)
    theirs = min((k for k in published.MSE_ANN if k != 6), key=published.MSE_ANN.__getitem__)
    told = ", ".join(f"{k}: {short(network[k])} ({short(published.MSE_ANN[k])})" for k in network)
    why = f"The networks are ahead on {len(ahead)} of {len(network)} data sets (the paper: all). "
    if small != theirs:
        why += f"The best small one is {small}, in the paper {theirs}. "
    own = results["data-sets"]["at_own_levels"][str(theirs)]
    if own is not None:
        why += (
            f"The network of set {theirs} errs by {short(own)} on the test cases at its own levels of the rudder, and "
            f"by {short(network[theirs])} on all: it has not seen the levels between, where most tests are."
        )
    return Finding(
        f"Networks here (the paper's): {told}.",
        agreed(small == theirs and len(ahead) == len(network)),
        why,
    )


def outlier_by_data_set(k: int) -> Callable[[Results], Finding]:
    """Figures 29-32: speeds of networks of three data sets at one of the paper's four cases."""

    def find(results: Results) -> Finding:
        found = results["data-sets"]
        exact = found["exact_kt"][k]
        errors = {name: _errors(speeds[k], exact) for name, speeds in found["estimates_kt"].items()}
        third, fifth, whole = (errors[f"data set {n}"][1] for n in (3, 5, 6))
        near = abs(third - whole) < FALLS_KT
        fifth_near = abs(fifth - whole) < FALLS_KT
        expected = near and fifth_near == (k != 0)
        on_lattice = "" if published.OUTLIERS[k][2] % 10.0 == 0.0 else f" {NOT_ON_THE_LATTICE}"
        return Finding(
            f"Exact {exact[0]:.1f} .. {exact[1]:.1f} kn. {_told(errors)}",
            agreed(expected),
            f"V_max of data set 3 is {abs(third - whole):.1f} kn from that of the whole one, of data set 5 "
            f"{abs(fifth - whole):.1f} kn." + on_lattice,
        )

    return find


def neurons(results: Results) -> Finding:
    """Figure 41: errors by hidden neurons."""
    found = results["neurons"]
    medians = dict(zip(found["neurons"], map(median, found["mse_independent"]), strict=True))
    chosen = max((n for n in medians if n <= published.NEURONS), default=min(medians))
    beyond = {n: mse for n, mse in medians.items() if n > chosen}
    told = ", ".join(f"{n}: {short(medians[n])}" for n in (1, 4, 10, 16, 20) if n in medians)
    least = min(beyond, key=beyond.__getitem__, default=chosen)
    gain = medians[chosen] / medians[least]
    return Finding(
        f"Median error by neurons: {told}; least at {least}.",
        agreed(gain < FACTOR),
        f"The paper finds no gain beyond {published.NEURONS}. Here the median falls by another factor of {gain:.1f} up "
        f"to {least} neurons"
        + (", on the lattice; that says little about the flight conditions between its levels." if gain > 1.0 else "."),
    )
