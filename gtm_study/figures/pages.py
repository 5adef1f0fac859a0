"""Interactive pages that need nothing but themselves: plotly and its library inside one file, for any width."""

from html import escape
from importlib.resources import files
from string import Template
from typing import Any

_PAGE = Template("""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>$title</title>
<style>
html, body { height: 100%; margin: 0; }
body > div { height: 100%; min-height: 26rem; }
</style>
</head>
<body>
$figure
</body>
</html>
""")


def page(figure: Any, title: str, **layout: Any) -> str:
    """The page of a plotly figure: title in lines that a phone can hold, legend below, as large as the window."""
    figure.update_layout(
        title={"text": title.replace("; ", "<br>"), "x": 0.5, "xanchor": "center", "font": {"size": 15}},
        template="plotly_white",
        legend={"orientation": "h", "yref": "container", "y": 0.01, "yanchor": "bottom", "x": 0.5, "xanchor": "center"},
        margin={"l": 10, "r": 10, "t": 70, "b": 130},
        xaxis={"automargin": True},
        yaxis={"automargin": True},
    )
    figure.update_layout(**layout)
    body = figure.to_html(
        full_html=False, include_plotlyjs=True, default_height="100%", config={"responsive": True, "displaylogo": False}
    )
    return _PAGE.substitute(title=escape(title), figure=body)


def page_style() -> str:
    """Colours for light and dark, type and tables that the pages share, as CSS."""
    return (files("gtm_study.figures") / "web" / "page.css").read_text(encoding="utf-8")
