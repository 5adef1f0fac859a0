"""A hook of MkDocs: equations in LaTeX become MathML when the site is built, so that a reader needs no script.

Few systems have a font for mathematics, so the site brings its own.
"""

import base64
import html
import re
from pathlib import Path
from typing import Any

from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

EQUATION = re.compile(r'<(span|div) class="arithmatex">\\[(\[](.*?)\\[)\]]</\1>', re.DOTALL)
FUNCTION = "<mi>(?:sin|cos|tan|arcsin|arctan|exp|ln)</mi>"
OPERAND = "mi|mn|mover|msub|msup|mfrac|msqrt|mstyle"
BEFORE, AFTER = re.compile(f"(</(?:{OPERAND})>)({FUNCTION})"), re.compile(f"({FUNCTION})(<(?:{OPERAND})>)")
THIN = '<mspace width="0.167em" />'
SIGN = re.compile("(<mo[^>]*>&#x000(?:3D|28|2C);</mo>)<mo>(?=&#x02212;)")
"""A minus behind an equals sign, a bracket or a comma: of one number, not between two."""
FONT = Path(__file__).parent / "font" / "stix-two-math.woff2"
STYLE_SHEET = "assets/equations.css"


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the style sheet that holds the font itself: from a file some browsers load no font beside it."""
    font = base64.b64encode(FONT.read_bytes()).decode()
    face = f'@font-face {{ font-family: "Equations"; src: url("data:font/woff2;base64,{font}"); }}\n'
    files.append(File.generated(config, STYLE_SHEET, content=face))
    return files


def on_page_content(content: str, **_: Any) -> str:
    """Equations of a page, as pymdownx.arithmatex marks them, as MathML."""
    return EQUATION.sub(_mathml, content)


def _mathml(found: re.Match[str]) -> str:
    display = "block" if found[1] == "div" else "inline"
    made = convert(html.unescape(found[2]).strip(), display=display)
    made = SIGN.sub(r'\1<mo form="prefix">', made)
    return BEFORE.sub(rf"\1{THIN}\2", AFTER.sub(rf"\1{THIN}\2", made))
