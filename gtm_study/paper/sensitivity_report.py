"""The indices of the study in words and tables, beside the paper's."""

from collections.abc import Mapping
from typing import Any

from gtm_study.paper import published
from gtm_study.paper.rudder_sensitivity import AS_IN_THE_PAPER, EXACT, WHETHER, WITH_AN_ENVELOPE
from gtm_study.tables import Section, Table

KINDS = {"first": "S", "total": "S^T"}
ASKED = {
    AS_IN_THE_PAPER: "V_min and V_max of every case; where there is no envelope the paper's network continues them.",
    WITH_AN_ENVELOPE: "V_min and V_max, given that there is an envelope; all inputs then depend on each other.",
    WHETHER: "Whether there is an envelope (1 or 0), and the least throttle of a steady manoeuvre, t_min.",
}
PUBLISHED_SUMS = (
    "For dependent inputs S of one limit, S^T of the other and the closed index of altitude and flight path add up to "
    "at most 1. In the paper's Table 15 the sums are 1.147 and 1.074: its S^T of one limit are what both limits "
    "together have here."
)


def sensitivity_sections(rudder: Mapping[str, Any], every: Mapping[str, Any]) -> list[Section]:
    """Tables of a failed rudder, question by question, and of everything that may fail."""
    asked = (
        "Altitude, flight path, and limits uniform on their triangle. S is V[E(f | y)] / V(f), S^T is E[V(f | all "
        f"but y)] / V(f). {rudder['without_envelope']:.1%} of the cases have no envelope: there are three questions. "
        f"The indices are sums over {_cells(rudder['cells'])} cells of altitude, flight path and rudder: there is no "
        "sampling, and no interval."
    )
    sections = [Section("Variance-based indices of a failed rudder", 2, (asked,))]
    for question, found in rudder["questions"].items():
        tables = [_table(question, found["answers"], kind) for kind in KINDS]
        errors = ", ".join(f"of the {name} {error:.4f}" for name, error in found["own_error"].items())
        told = (
            f"Largest error of its own, against the exact indices over the same cells: {errors}. With "
            f"{_cells(rudder['finer_cells'])} cells, as here for the thrust map, no index moves by more than "
            f"{found['cells_error']:.4f}."
        )
        further = (PUBLISHED_SUMS,) if question == AS_IN_THE_PAPER else ()
        sections.append(Section(question.capitalize(), 3, (ASKED[question], *tables, told, *further)))
    return [*sections, _every(every)]


def _cells(cells: Mapping[str, int]) -> str:
    return " x ".join(map(str, cells.values()))


def _table(question: str, answers: Mapping[str, Any], kind: str) -> Table:
    rows, with_paper = [], question == AS_IN_THE_PAPER
    for output, entry in answers[EXACT].items():
        for factor in entry["indices"]:
            cells = [f"{output}: {factor.replace(',', ', ')}"]
            for found in answers.values():
                cells.append(f"{found[output]['indices'][factor][kind]:.3f}" if output in found else "-")
            if with_paper:
                known = published.VARIANCE_INDICES[output].get(factor, {})
                cells.append(f"{known[kind]:.4f}" if kind in known else "-")
            rows.append(tuple(cells))
    heads = (KINDS[kind], *answers, *(["paper"] if with_paper else []))
    return Table(heads, rows, f"{'First-order' if kind == 'first' else 'Total'} indices, {question}")


def _every(every: Mapping[str, Any]) -> Section:
    parts: list[str | Table] = []
    for name, found in every.items():
        rows = []
        for output, entry in found["outputs"].items():
            for factor, values in entry["indices"].items():
                estimates = (values[kind] for kind in KINDS)
                cells = (f"{value['value']:.3f} ({value['lower']:.3f} .. {value['upper']:.3f})" for value in estimates)
                rows.append((f"{output}: {factor.replace(',', ', ')}", *cells))
        mean = found["outputs"]["has_envelope"]["mean"]
        said = (f"{_words(found['least_surfaces'][output])} for {output}" for output in found["outputs"])
        parts += [
            f"{name.capitalize()}: {found['n_evaluations']} exact envelopes, {mean:.0%} of the cases have one. The "
            f"surface whose limits matter least (S^T): {', '.join(said)}. The 95 % intervals are of the sampling; "
            "there is no surrogate.",
            Table(("factor", *KINDS.values()), rows, f"Indices of {name} that may fail"),
        ]
    return Section("Everything that may fail", 2, tuple(parts))


def _words(surfaces: list[str]) -> str:
    """The first surface, and those that are not told apart from it."""
    least, *others = surfaces
    return f"{least} (not told apart from {' and '.join(others)})" if others else least
