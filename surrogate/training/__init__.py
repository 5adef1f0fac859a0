"""From samples to fitted models: training, and selection among many trainings."""
