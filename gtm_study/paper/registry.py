"""Every figure and table of the paper with what the study has in its place: same, better, different, and why."""

from gtm_study.paper import envelope_findings, network_findings, published, sensitivity_findings
from gtm_study.paper.counterpart import Counterpart, Finding, Results, Verdict
from gtm_study.tables import Section, Table

SCHEMATIC = "A drawing of a method; the method itself is implemented and documented."
C = Counterpart

FIGURES = (
    C(
        "Figure 1",
        "Envelope volume over flight path, rudder jammed at 10 deg, sea level",
        "V_max falls as the flight path steepens.",
        "volume",
        envelope_findings.volume,
        figure="volume",
    ),
    C(
        "Figure 2",
        "The same, unimpaired aircraft",
        "The whole volume.",
        "volume",
        envelope_findings.healthy_volume,
        figure="volume_unimpaired",
    ),
    C(
        "Figure 3",
        "Envelopes of jammed rudders at 10 000 ft and -5 deg",
        "A jam at 0 deg leaves V_min and V_max as they were; the larger the jam, the smaller the envelope.",
        "jams",
        envelope_findings.jams,
        figure="envelope_jams",
    ),
    C("Figure 4", "The two-layer network", "4 inputs, 10 hidden neurons, 2 outputs.", reason=SCHEMATIC),
    C("Figure 5", "Structure of a local model network", "Local models weighted by validity.", reason=SCHEMATIC),
    C("Figure 6", "Drawing of GTM-T2", "5.5 % scale, two turbines.", reason="A drawing of the airframe."),
    C("Figure 7", "The Simulink model", "GTM_DesignSim.", reason="A screenshot; the model here is CasADi and C."),
    C(
        "Figure 8",
        "How a trim point is examined",
        "Feasible, then stable or controllable.",
        "trims",
        envelope_findings.trim_points,
    ),
    C("Figure 9", "Structure of the training data", "Inputs 4 x T, targets 2 x T.", reason=SCHEMATIC),
    C(
        "Figure 10",
        "Errors of 20 networks by two trainings",
        "Both about 1e-4; Bayesian regularisation mostly ahead; networks 7, 9 and 15 by Levenberg-Marquardt far off.",
        "levenberg-marquardt",
        network_findings.trainings,
        figure="trainings",
    ),
    C(
        "Figure 11",
        "Training of the best Bayesian network",
        "Network 4.",
        "networks",
        network_findings.bayesian_training,
        figure="bayesian_regularization_training",
    ),
    C(
        "Figure 12",
        "Its regression",
        "R close to 1 on all parts.",
        "networks",
        network_findings.bayesian_regression,
        figure="bayesian_regularization_regression",
    ),
    C(
        "Figure 13",
        "Histogram of its errors",
        "Independent test data.",
        "networks",
        network_findings.bayesian_histogram,
        figure="bayesian_regularization_errors",
    ),
    C(
        "Figure 14",
        "Training of the best network, Levenberg-Marquardt",
        "Network 13.",
        "levenberg-marquardt",
        network_findings.plain_training,
        figure="levenberg_marquardt_training",
    ),
    C(
        "Figure 15",
        "Its regression",
        "R close to 1 on all parts.",
        "levenberg-marquardt",
        network_findings.plain_regression,
        figure="levenberg_marquardt_regression",
    ),
    C(
        "Figure 16",
        "Histogram of its errors",
        "Independent test data.",
        "levenberg-marquardt",
        network_findings.plain_histogram,
        figure="levenberg_marquardt_errors",
    ),
    C(
        "Figure 17",
        "Networks and local model networks, 20 rounds",
        "The networks are ahead in all 20 rounds.",
        "local-models",
        network_findings.against_local_models,
        figure="networks_and_local_models",
    ),
    C(
        "Figure 18",
        "Local model networks by output",
        "Network 18 is best; errors of V_max exceed those of V_min.",
        "local-models",
        network_findings.local_by_output,
        figure="local_models_by_output",
    ),
    C(
        "Figure 19",
        "Networks by output",
        "Network 4 is best.",
        "networks",
        network_findings.networks_by_output,
        figure="networks_by_output",
    ),
    C(
        "Figure 20",
        "Growth of the best local model network of V_max",
        "24 models, 452 parameters.",
        "local-models",
        network_findings.growth,
        figure="growth_best",
    ),
    C(
        "Figure 21",
        "Training errors of its round's six",
        "Quadratic models by HILOMOT win.",
        "local-models",
        network_findings.growth,
        figure="growth_training",
    ),
    C(
        "Figure 22",
        "Validation errors of its round's six",
        "Quadratic models by HILOMOT win.",
        "local-models",
        network_findings.growth,
        figure="growth_validation",
    ),
    C(
        "Figure 23",
        "Squared errors of V_max on the independent test data",
        "111 cases; four outliers of the local models.",
        "local-models",
        network_findings.squared_errors,
        figure="squared_errors",
    ),
    *(
        C(
            number,
            f"{shows}: speeds of the best models",
            claim,
            "outliers",
            network_findings.outlier(k),
            figure=f"outlier_{k + 1}",
        )
        for k, (number, shows, claim) in enumerate(
            (
                ("Figure 24", "Rudder -30 .. 10 deg, 30 000 ft, 1 deg", "The local models give V_max far too low."),
                ("Figure 25", "Rudder jammed at 10 deg, 30 000 ft, 0 deg", "The local models give V_max far too low."),
                ("Figure 26", "Rudder jammed at 25 deg, 10 000 ft, -5 deg", "The local models give V_max far too low."),
                ("Figure 27", "Rudder jammed at 25 deg, 10 000 ft, -4 deg", "The local models give V_max far too low."),
            )
        )
    ),
    C(
        "Figure 28",
        "Errors by data set",
        "Networks are ahead on all six; data set 3 is the best of the small ones.",
        "data-sets",
        network_findings.data_sets,
        figure="data_sets",
    ),
    *(
        C(
            number,
            f"{shows}: networks of data sets 3, 5 and 6",
            claim,
            "data-sets",
            network_findings.outlier_by_data_set(k),
            figure=f"outlier_{k + 1}_data_sets",
        )
        for k, (number, shows, claim) in enumerate(
            (
                ("Figure 29", "Rudder -30 .. 10 deg, 30 000 ft, 1 deg", "3 is close to 6; 5 errs in V_max."),
                ("Figure 30", "Rudder jammed at 10 deg, 30 000 ft, 0 deg", "3 and 5 are close to 6."),
                ("Figure 31", "Rudder jammed at 25 deg, 10 000 ft, -5 deg", "3 and 5 are close to 6."),
                ("Figure 32", "Rudder jammed at 25 deg, 10 000 ft, -4 deg", "3 and 5 are close to 6."),
            )
        )
    ),
    C(
        "Figure 33",
        "V_max over both limits of the rudder, 10 000 ft, level",
        "Flat, but for jams and narrow ranges far from neutral.",
        "limits",
        envelope_findings.limit_surface,
        figure="limits",
    ),
    C(
        "Figure 34",
        "V_max over altitude and flight path, rudder jammed at 15 deg",
        "V_max falls as the path steepens, and drastically at high altitudes.",
        "paths",
        envelope_findings.path_surface,
        figure="paths",
    ),
    C(
        "Figure 35",
        "Elementary effects on V_max",
        "Flight path strongest; the limits least, with the largest deviations.",
        "effects",
        sensitivity_findings.effects("v_max_kt"),
        figure="effects_v_max",
    ),
    C(
        "Figure 36",
        "Elementary effects on V_min",
        "Altitude strongest, flight path none; the limits with the largest deviations.",
        "effects",
        sensitivity_findings.effects("v_min_kt"),
        figure="effects_v_min",
    ),
    C(
        "Figure 37",
        "Indices of V_max",
        "Flight path first, then altitude.",
        "sensitivity",
        sensitivity_findings.indices("v_max_kt"),
        figure="indices",
    ),
    C(
        "Figure 38",
        "Indices of V_min",
        "Altitude first; flight path none.",
        "sensitivity",
        sensitivity_findings.indices("v_min_kt"),
        figure="indices",
    ),
    C(
        "Figure 39",
        "Convergence of the indices of V_max",
        "Settled at 3 million evaluations, in 100 minutes.",
        "convergence",
        sensitivity_findings.convergence("v_max_kt"),
        figure="convergence_v_max",
    ),
    C(
        "Figure 40",
        "Convergence of the indices of V_min",
        "Settled at 3 million evaluations, in 100 minutes.",
        "convergence",
        sensitivity_findings.convergence("v_min_kt"),
        figure="convergence_v_min",
    ),
    C(
        "Figure 41",
        "Error by number of hidden neurons",
        "Falls up to 4 neurons, scatters from 5 to 9, no gain beyond 10.",
        "neurons",
        network_findings.neurons,
        figure="neurons",
    ),
)

TABLES = (
    C(
        "Table 1",
        "Inputs of the networks",
        "h, gamma and both limits of the rudder.",
        "lattice",
        envelope_findings.inputs,
        table="inputs",
    ),
    C(
        "Table 2",
        "Properties of GTM-T2",
        "Dimensions and mass.",
        "trims",
        envelope_findings.properties,
        table="properties",
    ),
    C(
        "Table 3",
        "Rudder failures of the training data",
        "7 jams and 21 restrictions.",
        "lattice",
        envelope_findings.failures,
        table="failures",
    ),
    C(
        "Table 4",
        "3-D envelopes of the training data",
        "112 cases.",
        "lattice",
        envelope_findings.envelopes_3d,
        table="envelopes",
    ),
    C(
        "Table 5",
        "Increments of speed, flight path and turn rate",
        "1 deg in flight path.",
        "lattice",
        envelope_findings.increments,
        table="steps",
    ),
    C(
        "Table 6",
        "Errors of 20 networks by two trainings",
        f"Best: {published.MSE_ANN[6]:.2e} by Bayesian regularisation (network 4).",
        "levenberg-marquardt",
        network_findings.trainings,
        table="rounds",
    ),
    *(
        C(
            f"Table {number}",
            f"Levels of data set {data_set}",
            f"{published.TRAINING_SAMPLES[data_set]} samples.",
            "lattice",
            envelope_findings.samples(data_set),
            table=f"data_set_{data_set}",
        )
        for number, data_set in zip(range(7, 13), (6, 1, 2, 3, 4, 5), strict=True)
    ),
    C(
        "Table 13",
        "The five diminished data sets",
        "Samples of each.",
        "lattice",
        envelope_findings.counts,
        table="counts",
    ),
    C(
        "Table 14",
        "Errors and samples by data set",
        "Networks ahead on all six.",
        "data-sets",
        network_findings.data_sets,
        table="data_sets",
    ),
    C(
        "Table 15",
        "Indices of V_max and V_min",
        "First, second and total indices.",
        "sensitivity",
        sensitivity_findings.table_15,
        table="indices",
    ),
)

COUNTERPARTS: tuple[Counterpart, ...] = (*FIGURES, *TABLES)


def ours(counterpart: Counterpart, results: Results) -> str:
    """Our number or finding in words; empty where there is none."""
    return counterpart.finding(results).ours


def verdict(counterpart: Counterpart, results: Results) -> Verdict:
    """Same, better or different; none without a counterpart, or before its stage is finished."""
    return counterpart.finding(results).verdict


def why(counterpart: Counterpart, results: Results) -> str:
    """What the verdict rests on."""
    return counterpart.finding(results).why


def comparison(results: Results) -> Section:
    """All that have a counterpart, by the stages that are finished."""
    rows = [
        (each.number, each.shows, each.published, found.ours or "-", found.verdict, found.why)
        for each in COUNTERPARTS
        if each.stage
        for found in [each.finding(results)]
    ]
    heads = ("paper", "shows", "the paper says", "here", "verdict", "why")
    return Section("The paper, figure by figure", 2, (Table(heads, rows),))


__all__ = ["COUNTERPARTS", "Counterpart", "Finding", "Results", "Verdict", "comparison", "ours", "verdict", "why"]
