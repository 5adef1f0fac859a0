"""The stages of the study in their order: what each needs, and from which level on it belongs."""

from gtm_study.paper import envelope_stages as envelopes
from gtm_study.paper import network_stages as networks
from gtm_study.paper import sensitivity_stages as sensitivities
from gtm_study.paper.stage import LEVELS, USUAL_LEVEL, Run, Sizes, Stage

QUICK, PAPER, FULL = LEVELS

STAGES = (
    Stage("trims", "Trims over the FMU and in the core", envelopes.trims),
    Stage("lattice", "Envelopes of the lattice", envelopes.lattice_stage),
    Stage("jams", "Envelopes of jammed rudders", envelopes.jams),
    Stage("volume", "Envelopes over flight path", envelopes.volume),
    Stage("limits", "Highest speed over rudder limits", envelopes.limits),
    Stage("paths", "Highest speed over altitude and path", envelopes.paths_stage),
    Stage("surrogate-fmu", "FMU of the surrogate", envelopes.surrogate_fmu),
    Stage("explorer", "Page of the explorer", envelopes.explorer),
    Stage("networks", "The paper's networks", networks.networks, ("lattice",)),
    Stage("sensitivity", "Sensitivity", sensitivities.sensitivity, ("networks",)),
    Stage("effects", "Elementary effects", sensitivities.effects, ("networks",)),
    Stage("convergence", "Convergence of the indices", sensitivities.convergence_stage, ("networks",)),
    Stage("levenberg-marquardt", "Networks without regularisation", networks.levenberg_marquardt, ("networks",)),
    Stage("advice", "Advice", sensitivities.advice_stage),
    Stage("feasibility", "Where an envelope exists", envelopes.feasibility, level=PAPER),
    Stage("asymmetry", "Mirrored failures", envelopes.asymmetry_stage, level=PAPER),
    Stage("local-models", "Local model networks", networks.local_models, ("networks",), PAPER),
    Stage("outliers", "The paper's outliers", networks.outliers, ("local-models",), PAPER),
    Stage("data-sets", "Diminished data sets", networks.data_sets, ("local-models",), PAPER),
    Stage("neurons", "Hidden neurons", networks.neurons, ("lattice",), PAPER),
    Stage("certainty", "Manoeuvres beyond the envelopes", envelopes.certainty_stage, level=FULL),
    Stage("exact-indices", "Exact indices anew", sensitivities.exact_indices, level=FULL),
    Stage("splits", "Networks over several splits", networks.splits, ("data-sets", "levenberg-marquardt"), FULL),
    Stage("surrogates", "Surrogates off the lattice", sensitivities.surrogates, level=FULL),
    Stage("all-failures", "Everything that may fail, anew", sensitivities.all_failures, level=FULL),
)
"""A stage needs only stages before it."""

__all__ = ["LEVELS", "STAGES", "USUAL_LEVEL", "Run", "Sizes", "Stage"]
