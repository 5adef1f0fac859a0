"""Results printed in the paper, for comparison only; nothing is computed from them (levels: `gtm_fmu.datasets.paper`).

"Investigating the Generalization Capability and Performance of Neural Networks and Neuro-Fuzzy Systems for Nonlinear
Dynamics Modeling of Impaired Aircraft". MSE is of targets scaled to 0..1 (section III-D), averaged over V_min and V_max
(eq. 11). Names of inputs and outputs are this project's.
"""

from gtm_fmu.datasets import paper

LATTICE_LEVELS = {
    "altitude_ft": paper.ALTITUDES_FT,
    "gamma_deg": paper.GAMMAS_DEG,
    "rudder_lower_deg": paper.RUDDERS_DEG,
    "rudder_upper_deg": paper.RUDDERS_DEG,
}
"""Table 7: levels of the data set by input; pairs with lower <= upper."""

ENVELOPES_3D = 112
"""Section III-C: altitudes times failure cases."""

FEASIBLE_CASES = 1102
"""Sections III-C and III-E, Table 14: 2-D envelopes, one sample each. Of the lattice of Table 7, 1232 are possible."""

INDEPENDENT_TEST_CASES = 111
"""Section III-D, Fig. 23: the independent test data, 10 % of the samples (Algorithm 1)."""

TRAINING_ROUNDS = 20
"""Section II-D, Algorithm 1: networks of which the best on the independent test data is kept."""

TRAINING_SAMPLES = {1: 260, 2: 261, 3: 344, 4: 71, 5: 88, 6: 1102}
"""Table 14: data set -> samples; 6 is the whole one."""

MSE_ANN = {1: 1.1746e-3, 2: 1.7366e-3, 3: 2.4953e-4, 4: 5.7781e-3, 5: 1.5934e-3, 6: 9.4251e-5}
"""Table 14: data set -> independent-test MSE of the best neural network (Bayesian regularisation for the whole set)."""

MSE_ORDER = 1e-4
"""Section III-D, Fig. 10: order of the errors of both trainings."""

MSE_LMN = {1: 1.2526e-3, 2: 4.7900e-3, 3: 1.9966e-3, 4: 1.2519e-2, 5: 2.8904e-3, 6: 1.2278e-4}
"""Table 14: data set -> independent-test MSE of the best local model network."""

VARIANCE_INDICES = {
    "v_max_kt": {
        "altitude_ft": {"first": 0.1687, "total": 0.2660},
        "gamma_deg": {"first": 0.4558, "total": 0.5528},
        "rudder_lower_deg": {"first": 0.1411, "total": 0.2848},
        "rudder_upper_deg": {"first": 0.1417, "total": 0.2840},
    },
    "v_min_kt": {
        "altitude_ft": {"first": 0.6809, "total": 0.6849},
        "gamma_deg": {"first": 0.0042, "total": 0.0051},
        "rudder_lower_deg": {"first": 0.1385, "total": 0.2498},
        "rudder_upper_deg": {"first": 0.1444, "total": 0.2501},
    },
}
"""Table 15: first-order and total indices, output -> input.

They break S_LL + ST_UL + S_{h, gamma} <= 1, which holds for any model: the sum is 1.147 for V_max and 1.074 for V_min.
"""

SECOND_ORDER_INDICES = {
    "v_max_kt": {"altitude_ft,gamma_deg": 0.0973, "rudder_lower_deg,rudder_upper_deg": 0.1437},
    "v_min_kt": {"altitude_ft,gamma_deg": 0.0, "rudder_lower_deg,rudder_upper_deg": 0.1113},
}
"""Table 15: ST less S, which the paper calls interaction; 0.0 is printed there as "≈ 0"."""

TRAJECTORIES = 12000
"""Section IV-C: of the elementary effects; radial, by a Latin hypercube, 60 000 evaluations."""

EVALUATIONS = 3_000_000
"""Section IV-C, Figs. 39-40: of the variance-based indices, in about 100 minutes; 30 000 a minute (section IV-A)."""

OUTLIERS = (
    (30000.0, 1.0, -30.0, 10.0),
    (30000.0, 0.0, 10.0, 10.0),
    (10000.0, -5.0, 25.0, 25.0),
    (10000.0, -4.0, 25.0, 25.0),
)
"""Figs. 24-27 and 29-32: altitude in ft, flight path and limits of the rudder in deg. 25 deg is no level of Table 3."""

BEST_NETWORK = {"bayesian_regularization": 4, "levenberg_marquardt": 13, "local_models": 18}
"""Section III-D: of the 20."""

LARGE_ERRORS = (7, 9, 15)
"""Fig. 10, Table 6: networks by Levenberg-Marquardt with larger errors."""

BEST_GROWTH = {"models": 24, "parameters": 452}
"""Figs. 20-22: of the best local model network of V_max, of quadratic models by HILOMOT."""

NEURONS = 10
"""Appendix, Fig. 41: hidden neurons beyond which the errors fall no more; 1 to 4 gain much, 5 to 9 scatter."""

MODEL_EVALUATIONS_A_MINUTE = 30_000
"""Section IV-A: of the emulator."""
