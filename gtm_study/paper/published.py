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
