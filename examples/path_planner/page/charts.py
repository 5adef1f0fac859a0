"""Charts as SVG whose colours are classes of the page's style, so that they follow its light or dark scheme."""

from collections.abc import Sequence
from html import escape

import numpy as np

WIDTH, LEFT, RIGHT, TOP, BOTTOM = 360.0, 44.0, 8.0, 8.0, 34.0
_TICKS = 5


def ticks(low: float, high: float) -> np.ndarray:
    """Round numbers inside a range, about `_TICKS` of them."""
    step = 10.0 ** np.floor(np.log10(max(high - low, 1e-9) / _TICKS))
    step *= next(factor for factor in (1, 2, 5, 10) if (high - low) / (step * factor) <= _TICKS + 1)
    return np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step + 0.0  # no -0


def spread(*columns: np.ndarray, part: float = 0.06) -> tuple[float, float]:
    """A range about all finite values, a little wider."""
    values = np.concatenate([np.ravel(column) for column in columns])
    values = values[np.isfinite(values)]
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    room = part * (high - low) or 1.0
    return low - room, high + room


class Chart:
    """One chart in the coordinates of its quantities."""

    def __init__(
        self, x: tuple[float, float], y: tuple[float, float], labels: tuple[str, str], height: float = 210.0
    ) -> None:
        """Room for quantities from ``x[0]`` to ``x[1]`` and ``y[0]`` to ``y[1]``."""
        self.x, self.y, self.labels, self.height = x, y, labels, height
        self._marks: list[str] = []

    @classmethod
    def of_map(cls, east: tuple[float, float], north: tuple[float, float], labels: tuple[str, str]) -> "Chart":
        """A chart with the same scale along both axes."""
        scale = (WIDTH - LEFT - RIGHT) / (east[1] - east[0])
        return cls(east, north, labels, (north[1] - north[0]) * scale + TOP + BOTTOM)

    def across(self, x: np.ndarray) -> np.ndarray:
        """Place from the left."""
        return LEFT + (np.asarray(x, float) - self.x[0]) / (self.x[1] - self.x[0]) * (WIDTH - LEFT - RIGHT)

    def down(self, y: np.ndarray) -> np.ndarray:
        """Place from the top."""
        part = (np.asarray(y, float) - self.y[0]) / (self.y[1] - self.y[0])
        return self.height - BOTTOM - part * (self.height - TOP - BOTTOM)

    def _points(self, x: np.ndarray, y: np.ndarray) -> str:
        pairs = zip(self.across(x).tolist(), self.down(y).tolist(), strict=True)
        return " ".join(f"{a:.1f},{b:.1f}" for a, b in pairs)

    def line(self, x: np.ndarray, y: np.ndarray, name: str) -> None:
        """A line, broken where a value is not finite."""
        known = np.isfinite(y)
        edges = np.flatnonzero(np.diff(np.concatenate([[0], known.astype(int), [0]])))
        for begin, end in zip(edges[::2], edges[1::2], strict=True):
            self._marks.append(f'<polyline class="{name}" points="{self._points(x[begin:end], y[begin:end])}"/>')

    def band(self, x: np.ndarray, low: np.ndarray, high: np.ndarray, name: str) -> None:
        """An area between two lines, broken where one is not finite."""
        known = np.isfinite(low) & np.isfinite(high)
        edges = np.flatnonzero(np.diff(np.concatenate([[0], known.astype(int), [0]])))
        for begin, end in zip(edges[::2], edges[1::2], strict=True):
            k = slice(begin, end)
            outline = np.concatenate([x[k], x[k][::-1]]), np.concatenate([low[k], high[k][::-1]])
            self._marks.append(f'<polygon class="{name}" points="{self._points(*outline)}"/>')

    def area(self, rings: Sequence[np.ndarray], name: str) -> None:
        """Rings (n, 2), with holes where one lies in another."""
        path = "".join(f"M{self._points(*ring.T)}Z" for ring in rings)
        self._marks.append(f'<path class="{name}" fill-rule="evenodd" d="{path}"/>')

    def circle(self, x: float, y: float, radius: float, name: str) -> None:
        """A circle with a radius in the quantity of the x axis."""
        wide = radius / (self.x[1] - self.x[0]) * (WIDTH - LEFT - RIGHT)
        here = f'cx="{float(self.across(np.float64(x))):.1f}" cy="{float(self.down(np.float64(y))):.1f}"'
        self._marks.append(f'<circle class="{name}" {here} r="{max(wide, 3):.1f}"/>')

    def cross(self, x: float, y: float, name: str) -> None:
        """A mark where something ends."""
        a, b = float(self.across(np.float64(x))), float(self.down(np.float64(y)))
        self._marks.append(f'<path class="{name}" d="M{a - 5:.1f} {b - 5:.1f}l10 10m0 -10l-10 10"/>')

    def text(self, x: float, y: float, words: str) -> None:
        """Words beside a place."""
        a, b = float(self.across(np.float64(x))), float(self.down(np.float64(y)))
        anchor = "end" if a > 0.7 * WIDTH else "start"
        a += -7 if anchor == "end" else 7
        self._marks.append(
            f'<text class="word" x="{a:.1f}" y="{b + 4:.1f}" text-anchor="{anchor}">{escape(words)}</text>'
        )

    def svg(self, name: str, alt: str) -> str:
        """The picture, with a name of its own on the page and a text alternative."""
        right, bottom = WIDTH - RIGHT, self.height - BOTTOM
        grid, words = [], []
        for value in ticks(*self.x):
            a = float(self.across(value))
            grid.append(f'<path class="grid" d="M{a:.1f} {TOP}V{bottom:.1f}"/>')
            words.append(f'<text x="{a:.1f}" y="{bottom + 14:.1f}" text-anchor="middle">{value:g}</text>')
        for value in ticks(*self.y):
            b = float(self.down(value))
            grid.append(f'<path class="grid" d="M{LEFT} {b:.1f}H{right:.1f}"/>')
            words.append(f'<text x="{LEFT - 5}" y="{b + 4:.1f}" text-anchor="end">{value:g}</text>')
        middle = 0.5 * (TOP + bottom)
        across, up = map(escape, self.labels)
        words.append(
            f'<text x="{0.5 * (LEFT + right):.1f}" y="{self.height - 4:.1f}" text-anchor="middle">{across}</text>'
        )
        words.append(f'<text transform="translate(11 {middle:.1f}) rotate(-90)" text-anchor="middle">{up}</text>')
        frame = f'<rect x="{LEFT}" y="{TOP}" width="{right - LEFT:.1f}" height="{bottom - TOP:.1f}"'
        return (
            f'<svg role="img" aria-label="{escape(alt, quote=True)}" viewBox="0 0 {WIDTH:g} {self.height:.0f}">'
            f'<clipPath id="{name}">{frame}/></clipPath>{"".join(grid)}'
            f'<g clip-path="url(#{name})">{"".join(self._marks)}</g>{frame} class="frame"/>{"".join(words)}</svg>'
        )
