"""Advice to a pilot or a path planner with a failure (paper section IV-C): what narrows the envelope, what is free.

The exact slopes here and now, and the cost of the next degree, stand beside the global indices: what matters over all
flight conditions and failures of that kind.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rich.box import SIMPLE
from rich.table import Column, Table

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe.names import CONTROLS
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.envelopes.slopes import Change, EnvelopeSlopes, Quantity, QuantitySlopes, Sides
from gtm_study.figures import captions
from gtm_study.paper import every_failure, rudder_grid, rudder_sensitivity
from sensitivity import Estimate

FREE_KT = 0.005
"""A loss below this is none: the ends are known to about that."""
_NAMES = {"v_min_kt": "V_min", "v_max_kt": "V_max"}
_INPUTS = {
    "altitude": "altitude",
    "gamma": "flight path",
    **{control: control for control in CONTROLS},
    "damage": "damage",
    "engine": "engine out",
}


@dataclass(frozen=True)
class GlobalShares:
    """Total indices by quantity and output, and what they are of."""

    of: str
    outputs: tuple[str, ...]
    total: Mapping[str, Mapping[str, float]]

    @property
    def sentence(self) -> str:
        """All quantities, limits of a control together, the weightiest first."""
        whole = {name: row for name, row in self.total.items() if name in _INPUTS}
        shares = sorted(whole.items(), key=lambda item: -max(item[1].values()))
        told = (f"{_INPUTS[name]} {' and '.join(f'{row[k]:.2f}' for k in self.outputs)}" for name, row in shares)
        return f"Shares of the variance (total indices) of {self.of}: {', '.join(told)}."


@dataclass(frozen=True)
class Move:
    """A quantity moved by a degree, a per cent or 1000 ft, and what that costs.

    Attributes:
        lost_kt: how much narrower the envelope is then, in kn; negative where it is wider, None where there is none.
    """

    slopes: QuantitySlopes
    change: Change
    lost_kt: float | None

    @property
    def quantity(self) -> Quantity:
        """What is moved."""
        return self.slopes.quantity

    @property
    def is_limit(self) -> bool:
        """Whether it is a limit that loses range."""
        return bool(self.quantity.narrowing)

    def slope(self, end: str) -> float | None:
        """Of ``v_min`` or ``v_max``, towards where the quantity is moved."""
        sides: Sides = getattr(self.slopes, end)
        return sides.above if self.change.to > self.quantity.value else sides.below

    @property
    def cost(self) -> float:
        """The loss in kn, infinite where no envelope is left."""
        return float("inf") if self.lost_kt is None else self.lost_kt


@dataclass(frozen=True)
class Advice:
    """Slopes and costs of an envelope beside the global shares."""

    slopes: EnvelopeSlopes
    shares: GlobalShares

    @property
    def moves(self) -> list[Move]:
        """Every move, the costliest first."""
        here = self.slopes.envelope
        if here.v_min_kt is None or here.v_max_kt is None:
            return []
        width, found = here.v_max_kt - here.v_min_kt, []
        for slopes in self.slopes.slopes:
            for change in slopes.changes:
                left = None if change.v_min_kt is None or change.v_max_kt is None else change.v_max_kt - change.v_min_kt
                found.append(Move(slopes, change, None if left is None else width - left))
        return sorted(found, key=lambda move: -move.cost)

    @property
    def narrowing_most(self) -> Move | None:
        """The limit whose next degree or per cent costs most; None if all are free."""
        costly = [move for move in self.moves if move.is_limit and move.cost > FREE_KT]
        return costly[0] if costly else None

    @property
    def free(self) -> list[Move]:
        """Limits whose next degree or per cent costs nothing."""
        return [move for move in self.moves if move.is_limit and move.cost <= FREE_KT]

    def to_dict(self) -> dict[str, Any]:
        """All of it, ready for JSON."""
        here, most = self.slopes.envelope, self.narrowing_most
        return {
            "feasible": here.feasible,
            "v_min_kt": here.v_min_kt,
            "v_max_kt": here.v_max_kt,
            "narrowing_most": most and most.quantity.name,
            "free": [move.quantity.name for move in self.free],
            "quantities": [self._quantity_to_dict(slopes) for slopes in self.slopes.slopes],
            "remedies": [
                {"name": quantity.name, "units": quantity.units, "value": quantity.value, "to": to}
                for quantity, to in self.slopes.remedies
            ],
            "global_indices": {"of": self.shares.of, "total": self.shares.total},
            "words": sentences(self),
        }

    def _quantity_to_dict(self, slopes: QuantitySlopes) -> dict[str, Any]:
        quantity = slopes.quantity
        moved = [
            {"to": m.change.to, "v_min_kt": m.change.v_min_kt, "v_max_kt": m.change.v_max_kt, "lost_kt": m.lost_kt}
            for m in self.moves
            if m.slopes is slopes
        ]
        return {
            "name": quantity.name,
            "units": quantity.units,
            "value": quantity.value,
            "v_min_slope": slopes.v_min._asdict(),
            "v_max_slope": slopes.v_max._asdict(),
            "kinks": list(slopes.kinks),
            "jumps": list(slopes.jumps),
            "moved": moved,
        }


def advice(slopes: EnvelopeSlopes) -> Advice:
    """Slopes with the global shares of their kind of failure."""
    return Advice(slopes, global_shares(slopes.envelope.failure))


def global_shares(failure: Failure) -> GlobalShares:
    """Of a failed rudder if nothing else has failed, else of everything that may fail."""
    if failure == Failure().with_limits("rudder_deg", failure.limits.rudder_deg):
        found = rudder_sensitivity.given_an_envelope(rudder_grid.exact())
        names = ("altitude", "gamma", "rudder.lower", "rudder.upper", "rudder")
        total = dict(zip(names, _rows(found.total, found.output_names), strict=True))
        return GlobalShares("V_min and V_max of the failed rudders that leave an envelope", found.output_names, total)
    is_whole = failure.configuration == Failure().configuration
    every = every_failure.indices(every_failure.CONTROLS_ONLY if is_whole else every_failure.EVERYTHING)
    failing = "all four controls fail" if is_whole else "controls, engines and structure fail"
    width = every_failure.OUTPUTS[-1:]
    by_control = {
        factor[0].split("_")[0]: {name: row[name] for name in width}
        for factor, row in zip(every.factors, _rows(every.total, every.output_names), strict=True)
    }
    by_control |= {f"throttle_{engine}": by_control["throttle"] for engine in ("left", "right")}
    total = {f"{name}{side}": row for name, row in by_control.items() for side in ("", ".lower", ".upper")}
    return GlobalShares(f"the width of the envelope, where {failing} at once", width, total)


def shares_by_kind() -> dict[str, str]:
    """What matters over all failures of the rudder alone, of controls, and of the airframe too: a sentence each."""
    kinds = {
        "rudder": Failure(),
        "controls": Failure(ControlLimits(aileron_deg=(0.0, 0.0))),
        "everything": Failure(configuration=Configuration(damage_case=1)),
    }
    return {kind: global_shares(one_of_them).sentence for kind, one_of_them in kinds.items()}


def _rows(estimate: Estimate, names: tuple[str, ...]) -> list[dict[str, float]]:
    return [dict(zip(names, row, strict=True)) for row in estimate.value.tolist()]


def title(quantity: Quantity) -> str:
    """A quantity in words."""
    control, _, side = quantity.name.partition(".")
    words = captions.words(control)
    return f"{side} limit of the {words}" if side else f"jam of the {words}" if control in _CONTROLS else words


_CONTROLS = (*CONTROLS, "throttle_left", "throttle_right")


def at(value: float, units: str) -> str:
    """A value with its unit."""
    return captions.value(round(value, 0 if units == "ft" else 2), units)


def moved(move: Move) -> str:
    """A move: what, from where to where."""
    quantity = move.quantity
    return f"{quantity.name} {at(quantity.value, '')} to {at(move.change.to, quantity.units)}"


def sentences(found: Advice) -> list[str]:
    """The advice in words, the answer first."""
    here = found.slopes.envelope
    where = f"{captions.condition(here.altitude_ft, here.gamma_deg)}, {captions.failure(here.failure)}"
    if here.v_min_kt is None or here.v_max_kt is None:
        return _without_envelope(found, where)
    width = here.v_max_kt - here.v_min_kt
    said = [f"At {where}: {here.v_min_kt:.1f} to {here.v_max_kt:.1f} kn, {width:.1f} kn wide."]
    if most := found.narrowing_most:
        said.append(f"What narrows it most when lost is the {title(most.quantity)}: {_consequence(most)}.")
    else:
        said.append("No limit of a control narrows it when its next degree or per cent is lost.")
    if found.free:
        said.append(f"Free: the next degree or per cent of {_list(found.free)} costs nothing.")
    ways: dict[str, list[Move]] = {}
    for move in found.moves:
        if not move.is_limit:
            ways.setdefault(title(move.quantity), []).append(move)
    said += [f"{name.capitalize()}: {'; '.join(map(_consequence, both))}." for name, both in ways.items()]
    for slopes in found.slopes.slopes:
        for jump in slopes.jumps:
            end, side = jump.replace("v_m", "V_m").split(".")
            said.append(
                f"{end} jumps just {side} the present value of the {title(slopes.quantity)}: it has no slope there."
            )
    return said


def _consequence(move: Move) -> str:
    to = f"at {at(move.change.to, move.quantity.units)}"
    if move.lost_kt is None:
        return f"{to} no envelope is left"
    if abs(move.lost_kt) <= FREE_KT:
        return f"{to} it is as wide"
    return f"{to} it is {abs(move.lost_kt):.2f} kn {'narrower' if move.lost_kt > 0 else 'wider'}"


def _list(moves: list[Move]) -> str:
    """Limits, both of a control together where both are there."""
    controls: dict[str, list[str]] = {}
    for move in moves:
        control, _, side = move.quantity.name.partition(".")
        controls.setdefault(control, []).append(side)
    return ", ".join(
        f"the {captions.words(control)} ({'both limits' if len(sides) > 1 else f'{sides[0]} limit'})"
        for control, sides in controls.items()
    )


def _beyond(quantity: Quantity, to: float) -> str:
    """A remedy rounded away from the present value, so that what is printed is one too."""
    unit = 1.0 if quantity.units == "ft" else 0.01
    rounded = (math.floor if to < quantity.value else math.ceil)(to / unit) * unit
    return at(min(max(rounded, quantity.allowed[0]), quantity.allowed[1]), quantity.units)


def _without_envelope(found: Advice, where: str) -> list[str]:
    nearest = found.slopes.envelope.nearest
    missed = f"; the nearest manoeuvre is {nearest.shortfall}" if nearest else ""
    said = [f"At {where}: no envelope{missed}."]
    remedies = [f"{title(quantity)} at {_beyond(quantity, to)}" for quantity, to in found.slopes.remedies]
    if remedies:
        said.append(f"Any one of these alone brings an envelope back: {'; '.join(remedies)}.")
    else:
        said.append("No altitude, flight path or limit alone brings an envelope back; more than one has to move.")
    return said


def table(found: Advice) -> Table:
    """The moves that cost or gain something."""
    caption = (
        "Slopes in kn per deg, % or 1000 ft, towards where it is moved; * a kink: the other side's differs. S^T: total "
        f"index of {found.shares.of}."
    )
    shares = found.shares.outputs
    heads = ["kn\nlost", "\nV_min", "\nV_max", "slope\nV_min", "slope\nV_max"]
    heads += [f"S^T\n{_NAMES.get(name, name.removesuffix('_kt'))}" for name in shares]
    columns = (Column(head, justify="right", no_wrap=True) for head in heads)
    table = Table(
        Column("\nmoved", no_wrap=True),
        *columns,
        box=SIMPLE,
        pad_edge=False,
        show_edge=False,
        collapse_padding=True,
        caption=caption,
    )
    for move in found.moves:
        if abs(move.cost) <= FREE_KT:
            continue
        total = found.shares.total.get(move.quantity.name, {})
        table.add_row(
            f"{move.quantity.name} to {at(move.change.to, move.quantity.units)}",
            "all" if move.lost_kt is None else _number(move.lost_kt),
            _number(move.change.v_min_kt),
            _number(move.change.v_max_kt),
            *(_slope(move, end) for end in ("v_min", "v_max")),
            *(_number(total.get(name)) for name in shares),
        )
    return table


def _slope(move: Move, end: str) -> str:
    slope, per = move.slope(end), 1000.0 if move.quantity.units == "ft" else 1.0
    return _number(None if slope is None else per * slope) + ("*" if end in move.slopes.kinks else "")


def _number(value: float | None) -> str:
    return "-" if value is None else f"{round(value, 2) + 0.0:.2f}"
