"""The C files of the core, for all that compile them: the package, native FMUs, tests. Standard library only."""

LAYERS = {
    "data and expressions": (
        "generated/tables.c",
        "generated/airframe.c",
        "generated/atmosphere.c",
        "generated/configured_tables.c",
        "generated/configured_airframe.c",
        "generated/actuators.c",
    ),
    "flight dynamics": (
        "gtm/unfold.c",
        "gtm/table.c",
        "gtm/motion.c",
        "gtm/condition.c",
        "gtm/lagrange.c",
        "gtm/configured_table.c",
        "gtm/configuration.c",
        "gtm/configured_motion.c",
        "gtm/simulation.c",
    ),
    "thrust map": ("thrust_map.c",),
    "trim map": ("trim_map.c",),
    "linear algebra and Newton": (
        "solver/linear_algebra.c",
        "solver/linear_program.c",
        "solver/stability.c",
        "solver/problem.c",
        "solver/newton.c",
        "solver/cold_start.c",
    ),
    "manifold": (
        "solver/cell.c",
        "solver/manifold.c",
        "solver/step.c",
        "solver/descent.c",
    ),
    "trims, ends and grids": (
        "solver/rudder_curve.c",
        "solver/trim.c",
        "solver/beyond.c",
        "solver/ends.c",
        "solver/end_slopes.c",
        "solver/grid.c",
    ),
    "the GTM-T2 as the solver takes it": ("gtm_t2.c",),
    "public functions": (
        "manoeuvres.c",
        "slopes.c",
        "linear_model.c",
        "query.c",
        "sections.c",
        "failure.c",
        "failure_slopes.c",
    ),
}
"""From the bottom up: a file calls only functions of files before it, and so do the layers."""

WHOLE = tuple(name for files in LAYERS.values() for name in files)

DYNAMICS = ("gtm/motion.c", "gtm/table.c", "gtm/unfold.c", "generated/airframe.c", "generated/tables.c")
"""What the flight dynamics of the study's configuration need."""

THRUST_MAP = ("thrust_map.c", "gtm/condition.c", "gtm/lagrange.c", "generated/atmosphere.c")
"""What the thrust map needs."""
