"""Scripts to copy."""
