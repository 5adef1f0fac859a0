"""Words for the figures and tables of the study that stand for none of the paper's."""

CAPTIONS = {
    "emulator_jams": "V_min and V_max of a jammed rudder: exact, and by the paper's network trained here",
    "bayesian_regularization_networks": "Errors of the networks on their training and on the independent test data",
    "bayesian_regularization_evidence": "Training of the best network: effective parameters, weights of the evidence",
    "levenberg_marquardt_networks": "Errors of the networks without regularisation on training and independent test",
    "advice_level": "What narrows or widens the envelope in level flight, and what matters over all such failures",
    "advice_climb": "The same in a climb of 3 deg",
    "nasa_trims_modes": "Level trims and modes over angle of attack, beside readings of NASA's plots",
    "feasibility": "The largest jam of the rudder that leaves an envelope, over altitude and flight path",
    "splits": "Errors of the methods over several divisions of the data",
    "data_sets_over_splits": "Errors by data set over several divisions of the data",
    "surrogate_errors": "Errors off the lattice over the number of exact solutions that a model learnt from",
    "effects": "Elementary effects on the paper's network: by the ranges of the inputs, and by the paper's scaling",
    "worst": "Squared errors of V_max at the four cases where the local models are worst",
    "outliers": "V_min and V_max at the paper's four cases, kn",
    "by_neurons": "Mean squared error on the independent test data by hidden neurons",
    "on_the_lattice": "Least mean squared error on the independent test data, split by split",
    "off_the_lattice": "Mean squared error between the levels of the lattice, split by split",
    "off_lattice": "Errors of all surrogates on random cases off the lattice",
}
"""By stem of the figure or key of the table."""


def caption(name: str) -> str:
    """Words for a figure or table; its name where there are none."""
    return CAPTIONS.get(name, name.replace("_", " "))
