"""What numbers were computed with: the version of the package and its aerodynamic data."""

import hashlib
from functools import cache
from importlib.metadata import version

from gtm_fmu.airframe.tables import DATA_FILE


@cache
def provenance() -> dict[str, str]:
    """Version of the package and hash of its aerodynamic data, as attributes of a data set."""
    data_hash = hashlib.sha256(DATA_FILE.read_bytes()).hexdigest()
    return {"gtm_fmu_version": version("gtm-fmu"), "aerodynamic_data_sha256": data_hash}
