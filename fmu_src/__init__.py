"""The FMUs of this project: what runs inside them, how they are described and packed."""

from fmu_src.packing.python_fmus import MODELS, NATIVE_MODELS, build

__all__ = ["MODELS", "NATIVE_MODELS", "build"]
