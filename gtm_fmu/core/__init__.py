"""The compiled core: state derivatives, outputs and Jacobians of the airframe on NumPy arrays."""

from gtm_fmu.core.library import library_path
from gtm_fmu.core.motion import advance, derivatives, jacobian, outputs, outputs_jacobian, state_fault

__all__ = ["advance", "derivatives", "jacobian", "library_path", "outputs", "outputs_jacobian", "state_fault"]
