"""Two FMUs that are none of ours."""
