"""The icon of the FMUs: the planform of the transport, drawn by the program."""

from io import BytesIO

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

# Right half of the outline, nose up, in half spans: nose, fuselage, wing, fuselage, stabiliser, tail.
_RIGHT = (
    (0.0, 0.95),
    (0.05, 0.88),
    (0.09, 0.75),
    (0.09, 0.30),
    (1.0, -0.25),
    (1.0, -0.38),
    (0.35, -0.15),
    (0.09, -0.15),
    (0.07, -0.68),
    (0.38, -0.88),
    (0.38, -0.97),
    (0.04, -0.88),
    (0.0, -0.98),
)
_ENGINE = ((0.29, 0.30), (0.37, 0.30), (0.37, 0.02), (0.29, 0.02))


def icon_png() -> bytes:
    """The icon as a PNG of 128 by 128 pixels; equal bytes from equal versions of matplotlib."""
    figure = Figure(figsize=(1.28, 1.28), dpi=100)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(-1.15, 1.15), ylim=(-1.15, 1.15), aspect="equal")
    axes.axis("off")
    for side in (1, -1):
        for outline in (_ENGINE, _RIGHT):
            axes.fill(*zip(*((side * x, y) for x, y in outline), strict=True), color="#1f4e79", linewidth=0.5)
    png = BytesIO()
    figure.savefig(png, format="png", transparent=True, metadata={"Software": None})
    return png.getvalue()
