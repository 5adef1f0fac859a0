"""README.md, docs and notebooks: every block of commands and of programs runs, in the order of its page.

Each page has a folder of its own, in which ``examples`` and ``tests`` stand as in the repository. A block of commands
is indented or fenced as ``sh``; indented lines that follow it at once and begin with no command are what it prints, or
some of it. A block that takes too long, or needs another machine, has ``<!-- not run: reason -->`` before it; its
commands, options and imports are checked.
"""

import ast
import contextlib
import importlib
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
import typer
from typer.exceptions import TyperException

from fmu_src import MODELS, fmus
from gtm_fmu import ControlLimits, Envelope, Trim, linearize, trim
from gtm_study.commands import cli

pytest.importorskip("nbformat", reason="the extra `docs` is not installed")
pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "docs" / "site"))
notebooks = importlib.import_module("notebooks")
PAGES = ("README.md", *sorted(path.relative_to(ROOT).as_posix() for path in (ROOT / "docs").rglob("*.md")))
COMMANDS = ("gtm-fmu", "python", "make", "node")
LANGUAGES = ("sh", "python", "c", "js", "text")
FENCE = re.compile(r"^```(\w*)$")
NOT_RUN = re.compile(r"^<!-- not run: (.+) -->$")


@dataclass(frozen=True)
class Block:
    """A block of a page: the line that it begins on, its language, its text, and why it is not run."""

    page: str
    line: int
    language: str
    text: str
    reason: str | None = None

    def __str__(self) -> str:
        return f"{self.page}:{self.line}"


def blocks(page: str) -> list[Block]:
    """The blocks of a page; two indented ones with nothing but empty lines between are two."""
    found: list[Block] = []
    language, start, held, reason = None, 0, [], None
    for number, line in enumerate([*(ROOT / page).read_text(encoding="utf-8").splitlines(), ""], 1):
        fence = FENCE.match(line)
        if language is None and fence:
            language, start, held = fence[1], number, []
        elif language == "indented" and not line.startswith("    "):
            text = "\n".join(held)
            is_command = text.split()[0] in COMMANDS
            found.append(Block(page, start, "sh" if is_command else "text", text, reason))
            language, reason = None, None
        elif language not in (None, "indented") and line == "```":
            found.append(Block(page, start, language, "\n".join(held), reason))
            language, reason = None, None
        elif language is not None:
            held.append(line[4:] if language == "indented" else line)
        elif line.startswith("    ") and line.strip():
            language, start, held = "indented", number, [line[4:]]
        elif mark := NOT_RUN.match(line):
            reason = mark[1]
        elif line:
            assert reason is None, f"{page}:{number}: a block follows `not run`"
    return found


def cells(path: Path) -> list[Block]:
    """The programs of a notebook."""
    page = path.relative_to(ROOT).as_posix()
    return [Block(page, cell.line, "python", cell.text) for cell in notebooks.cells(path) if not cell.is_text]


BLOCKS = [block for page in PAGES for block in blocks(page)]
NOTEBOOKS = {path.stem: cells(path) for path in notebooks.NOTEBOOKS}


def of(*languages: str, is_run: bool = True) -> list[Block]:
    return [block for block in BLOCKS if block.language in languages and (block.reason is None) == is_run]


def commands(block: Block) -> list[str]:
    """The commands of a block, without comments; one that ends in a backslash goes on."""
    joined = block.text.replace("\\\n", " ")
    return [line for line in joined.splitlines() if line.strip() and not line.lstrip().startswith("#")]


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """The folder of a page."""
    made: dict[str, Path] = {}

    def folder(page: str) -> Path:
        if page not in made:
            made[page] = tmp_path_factory.mktemp("page")
            for name in ("examples", "tests"):
                (made[page] / name).symlink_to(ROOT / name)
        return made[page]

    return folder


@pytest.fixture(scope="module")
def programs(quick_compiler) -> str:
    """Where commands are looked up: this Python's, and the C compiler."""
    return os.pathsep.join([str(quick_compiler), str(Path(sys.executable).parent), os.environ["PATH"]])


@pytest.fixture(scope="module", autouse=True)
def built_once():
    """What one page has built is not compiled again for another."""
    build, known = fmus.build, {}

    def build_or_copy(name, output, files=(), all_platforms=False, progress=None):
        asked = name, tuple(files), all_platforms
        if asked not in known:
            path = build(name, output, files, all_platforms, progress)
            known[asked] = path.name, path.read_bytes()
        file, content = known[asked]
        Path(output).mkdir(parents=True, exist_ok=True)
        Path(output, file).write_bytes(content)
        return Path(output, file)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fmus, "build", build_or_copy)
        yield


@pytest.fixture(scope="module")
def names():
    """What the programs of a page have defined so far."""
    return {}


@pytest.fixture
def place(request, folders, programs, monkeypatch) -> Path:
    folder = folders(request.getfixturevalue("block").page)
    monkeypatch.chdir(folder)
    monkeypatch.setenv("PATH", programs)
    return folder


def run(command: str, monkeypatch) -> str:
    """What a command prints: one of gtm-fmu in this process, any other by the shell."""
    words = shlex.split(command, comments=True)
    if words[0] == "gtm-fmu":
        monkeypatch.setattr(sys, "argv", words)
        printed, complaints = io.StringIO(), io.StringIO()
        redirected = contextlib.redirect_stdout(printed), contextlib.redirect_stderr(complaints)
        with redirected[0], redirected[1], pytest.raises(SystemExit) as ended:
            cli.main()
        assert ended.value.code == 0, f"{command}\n{complaints.getvalue()}"
        return printed.getvalue()
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def test_languages():
    for block in BLOCKS:
        assert block.language in LANGUAGES, f"{block}: a fence names its language, one of {LANGUAGES}"
        is_program = block.language == "text" and re.match(r"(from|import) \w|gtm-fmu ", block.text)
        assert not is_program, f"{block}: a program is fenced as python, a command as sh"
    assert len(of("sh")) >= 10
    assert len(of("python")) >= 9
    assert any(told_output(block) for block in of("sh"))


def test_signs():
    """README's table, in level flight and with a rudder jammed at 10 deg (SPEC 4 and 13)."""
    level = trim(10000, 118.5)
    B = dict(zip(("p", "q", "r"), linearize(level).B[3:6], strict=True))
    elevator, aileron, rudder = 0, 1, 2
    assert B["q"][elevator] < 0
    assert B["p"][aileron] < 0
    assert B["r"][rudder] < 0
    jammed = trim(10000, 118.5, limits=ControlLimits(rudder_deg=(10, 10)))
    assert (round(jammed.beta_deg, 1), round(jammed.phi_deg, 1)) == (7.7, 15.7)
    assert trim(10000, 118.5, 3.0, 5.0).phi_deg > 10
    assert trim(10000, 118.5, 3.0).theta_deg > level.theta_deg


def test_symbols():
    """Each name of the glossary is one in Python or of an FMU, shown in the unit that the glossary says."""
    models = [MODELS[name]([]).model for name in ("dynamics", "surrogate")]
    shown = {variable.name: variable.display_unit for model in models for variable in model.variables}
    rows = [
        [cell.strip().strip("`") for cell in line.split("|")[4:7]]
        for line in (ROOT / "docs/symbols.md").read_text(encoding="utf-8").splitlines()
        if line.startswith("| $") and line.count("|") == 7
    ]
    assert len(rows) >= 25
    endings = {"kn": "_kt", "%": "_pct", "g": "", "deg/s": "_deg_s"}
    for python, variable, unit in rows:
        assert not variable or shown[variable] == unit, variable
        assert not python or hasattr(Trim, python) or python in Trim.__annotations__ | Envelope.__annotations__, python
        assert python.endswith(endings.get(unit, f"_{unit}")) or not python, python


@pytest.mark.parametrize("page", PAGES)
def test_links(page):
    """Files and headings that a page links to are there."""
    text = (ROOT / page).read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if not target.startswith("http"):
            path, _, heading = target.partition("#")
            linked = (ROOT / page).parent / path if path else ROOT / page
            assert linked.exists(), f"{page} links to {target}"
            assert not heading or heading in headings(linked), f"{page} links to {target}"


def headings(path: Path) -> set[str]:
    """The anchors that a page's headings have."""
    titles = re.findall(r"^#+ (.+)$", path.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles}


def test_reasons():
    """Few blocks are not run, and each says why."""
    left_out = of(*LANGUAGES, is_run=False)
    assert len(left_out) <= len(BLOCKS) / 5, "run the block, or another one"
    for block in left_out:
        assert len(block.reason.split()) >= 3, f"{block}: say why it is not run"


@pytest.mark.parametrize("block", of("sh", "python", "c", "js"), ids=str)
def test_block(block, place, names, monkeypatch, capsys):
    if block.language == "sh":
        printed = [word for command in commands(block) for word in words(run(command, monkeypatch))]
        for line in told_output(block):
            assert any(is_same(printed[k : k + len(line)], line) for k in range(len(printed))), line
    elif block.language == "python":
        run_python(block, names.setdefault(block.page, {"__name__": "__main__"}))
    elif block.language == "c":
        run_c(block, place, monkeypatch)
    else:
        run_javascript(block, place, monkeypatch)


def told_output(block: Block) -> list[list[str]]:
    """What a page says that its commands print, line by line: the indented block that follows at once."""
    after = block.line + len(block.text.splitlines()) + 1
    follows = [each for each in BLOCKS if each.page == block.page and each.line == after and each.language == "text"]
    return [words(line) for each in follows for line in each.text.splitlines()]


def words(printed: str) -> list[str]:
    """Words of what is printed, without the lines of tables."""
    return re.sub("[\u2500-\u257f]", " ", printed).split()


def is_same(shown: list[str], told: list[str]) -> bool:
    """Whether words are the same, numbers to 2 %."""
    if len(shown) != len(told):
        return False
    pairs = [(word, other) for word, other in zip(shown, told, strict=True) if word != other]
    return all(
        NUMBER.fullmatch(word) and NUMBER.fullmatch(other) and float(word) == pytest.approx(float(other), rel=0.02)
        for word, other in pairs
    )


def run_python(block: Block, defined: dict) -> None:
    """A program; what it prints, and what its expressions are, is what the comments behind them say."""
    printed = io.StringIO()
    try:
        with contextlib.redirect_stdout(printed):
            exec(compile(block.text, str(block), "exec"), defined)
    except (ImportError, OSError) as error:
        if "libtbb" in str(error):
            pytest.skip("ecospy needs libtbb12")
        raise
    lines = block.text.splitlines()
    prints = [line for line in lines if line.lstrip().startswith("print(")]
    for line, shown in zip(reversed(prints), reversed(printed.getvalue().splitlines()), strict=False):
        compare(shown, line)
    for node in ast.parse(block.text).body:
        if isinstance(node, ast.Expr) and not ast.unparse(node).startswith("print("):
            line = lines[node.end_lineno - 1]
            if EXPECTED.search(line):
                compare(str(eval(compile(ast.Expression(node.value), str(block), "eval"), defined)), line)


EXPECTED = re.compile(r"  # ((?:[\[(]?-?\d|True|False).*?)(?:[:;]|$)")
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?")


def compare(shown: str, line: str) -> None:
    """What is shown is what the comment of a line of a page expects: numbers to 2 %, nothing where it expects none."""
    if expected := EXPECTED.search(line):
        numbers = [float(number) for number in NUMBER.findall(expected[1])]
        assert [float(number) for number in NUMBER.findall(shown)][: len(numbers)] == pytest.approx(numbers, rel=0.02)
        assert not numbers or shown, line
        if not numbers:
            assert shown == expected[1], line


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_notebook(name, tmp_path_factory, programs, monkeypatch):
    """Its cells run in order, in a folder beside that of the tables, and draw the figure that the site shows."""
    folder = tmp_path_factory.mktemp("examples")
    (folder / "tables").symlink_to(ROOT / "examples" / "tables")
    (folder / "notebooks").mkdir()
    plt = pytest.importorskip("matplotlib.pyplot")
    monkeypatch.chdir(folder / "notebooks")
    monkeypatch.setenv("PATH", programs)
    plt.close("all")
    defined = {"__name__": "__main__"}
    for cell in NOTEBOOKS[name]:
        run_python(cell, defined)
    assert len(plt.get_fignums()) == 1
    plt.close("all")
    assert (notebooks.IMAGES / f"{name}.png").exists()


def run_c(block: Block, place: Path, monkeypatch) -> None:
    """A program beside the exported C of its page; it prints what its comment says."""
    if shutil.which("cc") is None:
        pytest.skip("no C compiler: install gcc")
    (place / "program.c").write_text(block.text)
    sources = sorted(path.name for path in place.glob("*.c"))
    printed = run(f"cc -std=c99 -Wall -Werror {' '.join(sources)} -o program -lm && ./program", monkeypatch)
    assert f"/* {printed.strip()} */" in block.text


def run_javascript(block: Block, place: Path, monkeypatch) -> None:
    """A program beside the exported module of its page; the last value is what its comment says."""
    if shutil.which("node") is None:
        pytest.skip("no node: install nodejs")
    *before, last = block.text.splitlines()
    call, _, comment = last.partition("; // ")
    shown = f"console.log(JSON.stringify(Array.from({call}, x => Number(x.toPrecision(5)))))"
    (place / "program.mjs").write_text("\n".join([*before, shown]))
    assert run("node program.mjs", monkeypatch).strip() == comment.replace(" ", "")


@pytest.mark.parametrize("block", of("sh", is_run=False), ids=str)
def test_commands_that_are_not_run(block):
    """gtm-fmu knows the words; other commands are there, and the shell can read the block."""
    subprocess.run(["bash", "-n", "-c", block.text], check=True)
    for command in commands(block):
        program, *words = shlex.split(command, comments=True)
        if program == "gtm-fmu":
            parse(words)
        elif program == "make":
            assert re.search(rf"^{words[0]}:", (ROOT / "Makefile").read_text(), re.MULTILINE), command
        elif program == "python" and words[0] != "-m":
            described = subprocess.run([sys.executable, ROOT / words[0], "--help"], capture_output=True, text=True)
            assert all(word in described.stdout for word in words[1:] if word.startswith("--")), command
        elif program == "python":
            assert importlib.util.find_spec(words[1]), command


def parse(words: list[str]) -> None:
    """Read a command of gtm-fmu without running it."""
    command, name = typer.main.get_command(cli.app), "gtm-fmu"
    while hasattr(command, "commands"):
        name, *words = words
        assert name in command.commands, f"{name} is no command"
        command = command.commands[name]
    try:
        command.make_context(name, list(words))
    except TyperException as error:
        pytest.fail(f"{name} {' '.join(words)}: {error.format_message()}")


@pytest.mark.parametrize("block", of("python", is_run=False), ids=str)
def test_programs_that_are_not_run(block):
    """They compile, and what they import is there."""
    tree = ast.parse(block.text, str(block))
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                importlib.import_module(alias.name)
        elif isinstance(node, ast.ImportFrom):
            module = importlib.import_module(node.module)
            assert all(hasattr(module, alias.name) for alias in node.names)
