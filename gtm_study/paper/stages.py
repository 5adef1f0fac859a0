"""The stages of the study in their order: what each needs, and from which level on it belongs."""

from gtm_study.paper import envelope_stages as envelopes
from gtm_study.paper import network_stages as networks
from gtm_study.paper import sensitivity_stages as sensitivities
from gtm_study.paper.stage import LEVELS, USUAL_LEVEL, Run, Sizes, Stage

QUICK, PAPER, FULL = LEVELS

STAGES = (
    Stage("trims", "Trims over the FMU and in the core", envelopes.trims, 8),
    Stage("lattice", "Envelopes of the lattice", envelopes.lattice_stage, 8),
    Stage("jams", "Envelopes of jammed rudders", envelopes.jams, 1),
    Stage("volume", "Envelopes over flight path", envelopes.volume, 7),
    Stage("limits", "Highest speed over rudder limits", envelopes.limits, 1),
    Stage("paths", "Highest speed over altitude and path", envelopes.paths_stage, 3),
    Stage("surrogate-fmu", "FMU of the surrogate", envelopes.surrogate_fmu, 2),
    Stage("networks", "The paper's networks", networks.networks, 22, ("lattice",)),
    Stage("sensitivity", "Sensitivity", sensitivities.sensitivity, 5, ("networks",)),
    Stage("effects", "Elementary effects", sensitivities.effects, 1, ("networks",)),
    Stage("convergence", "Convergence of the indices", sensitivities.convergence_stage, 5, ("networks",)),
    Stage("levenberg-marquardt", "Networks without regularisation", networks.levenberg_marquardt, 4, ("networks",)),
    Stage("advice", "Advice", sensitivities.advice_stage, 1),
    Stage("explorer", "Page of the explorer", envelopes.explorer, 10, level=PAPER),
    Stage("nasa", "Level trims and modes beside NASA's", envelopes.nasa, 2, level=PAPER),
    Stage("feasibility", "Where an envelope exists", envelopes.feasibility, 3, level=PAPER),
    Stage("asymmetry", "Mirrored failures", envelopes.asymmetry_stage, 6, level=PAPER),
    Stage("local-models", "Local model networks", networks.local_models, 80, ("networks",), PAPER),
    Stage("outliers", "The paper's outliers", networks.outliers, 3, ("local-models",), PAPER),
    Stage("data-sets", "Diminished data sets", networks.data_sets, 110, ("local-models",), PAPER),
    Stage("neurons", "Hidden neurons", networks.neurons, 130, ("lattice",), PAPER),
    Stage("certainty", "Manoeuvres beyond the envelopes", envelopes.certainty_stage, 80, level=FULL),
    Stage("exact-indices", "Exact indices anew", sensitivities.exact_indices, 40, level=FULL),
    Stage("splits", "Networks over several splits", networks.splits, 500, ("data-sets", "levenberg-marquardt"), FULL),
    Stage("surrogates", "Surrogates off the lattice", sensitivities.surrogates, 600, level=FULL),
    Stage("all-failures", "Everything that may fail, anew", sensitivities.all_failures, 900, level=FULL),
)
"""A stage needs only stages before it."""

__all__ = ["LEVELS", "STAGES", "USUAL_LEVEL", "Run", "Sizes", "Stage"]
