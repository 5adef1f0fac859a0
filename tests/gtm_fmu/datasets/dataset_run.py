"""A run of a data set in a process of its own, to be killed: python dataset_run.py STORE."""

import sys

from gtm_fmu.datasets.axes import limits_span, span
from gtm_fmu.datasets.cases import CaseTable, Sampling
from gtm_fmu.datasets.distribution import compute

TABLE = CaseTable.sampled(
    [span("altitude", 0, 30000), span("gamma", -5, 5), limits_span("rudder", -30, 30, jam_share=0.8)],
    Sampling.SOBOL,
    cases=90,
    seed=1,
)
CHUNK = 4

if __name__ == "__main__":
    print(compute(sys.argv[1], TABLE, chunk=CHUNK, workers=2))
