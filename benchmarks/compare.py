"""Name each ratio that fell by more than a third since the published results: `compare.py MEASURED PUBLISHED`.

A ratio is against a peer of the same run, so that it may be compared across machines where a time may not.
"""

import json
import sys
from pathlib import Path

FALLEN = 2 / 3
"""Of the published ratio: below is named."""


def ratios(result: dict) -> dict[str, float]:
    """Ratios of one benchmark by what they compare; more is better."""
    rows = {f"{row['name']} against {row['peer']}": row["ratio"] for row in result.get("rows", ()) if "ratio" in row}
    return rows | {name: value for name, value in result.items() if name.startswith("times_faster")}


def compared(measured: Path, published: Path) -> list[str]:
    """A sentence for each ratio of the folder ``measured`` that fell, or that the published ones do not have."""
    sentences = []
    for path in sorted(measured.glob("*.json")):
        now = ratios(json.loads(path.read_text()))
        before = ratios(json.loads((published / path.name).read_text())) if (published / path.name).exists() else {}
        for name, ratio in now.items():
            if name not in before:
                sentences.append(f"{path.stem}: {name}: {ratio:g}, not among the published results.")
            elif ratio < FALLEN * before[name]:
                sentences.append(f"{path.stem}: {name}: fell from {before[name]:g} to {ratio:g}.")
        sentences += [f"{path.stem}: {name}: published, not measured now." for name in before if name not in now]
    return sentences


if __name__ == "__main__":
    found = compared(Path(sys.argv[1]), Path(sys.argv[2]))
    print("\n".join(found or ["No ratio fell by more than a third since the published results."]))
