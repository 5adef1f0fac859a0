"""The page of the study as PDF and as a picture, which headless Chromium makes.

``python -m gtm_study.report.browser build/study/index.html docs/images/study.png`` takes the picture that README shows.
"""

import argparse
import shutil
import subprocess
import sys
from pathlib import Path

from gtm_fmu.errors import InputError
from gtm_fmu.files import temporary_folder, write_whole

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
FLAGS = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--hide-scrollbars")
WINDOW = (1280, 1120)
"""Width and height of a picture in pixels."""
PDF = "study.pdf"
LONGEST_S = 180


def find_browser() -> str | None:
    """The program of Chromium, if there is one."""
    return next((path for name in BROWSERS if (path := shutil.which(name))), None)


def check_browser() -> str:
    """The program of Chromium; to be asked before a long computation.

    Raises:
        InputError: there is none.
    """
    if (found := find_browser()) is None:
        raise InputError(
            f"The PDF is printed by Chromium, and none of {', '.join(BROWSERS)} is here; install one (apt-get install "
            "chromium), or leave out --pdf and print index.html from any browser."
        )
    return found


def write_pdf(page: Path, path: Path) -> None:
    """Print a page to a PDF file.

    Raises:
        InputError: there is no browser, it fails, or the file cannot be written.
    """
    _write(page, path, b"%PDF", "--no-pdf-header-footer", "--print-to-pdf")


def write_picture(page: Path, path: Path) -> None:
    """Take a picture (.png) of the beginning of a page.

    Raises:
        InputError: there is no browser, it fails, or the file cannot be written.
    """
    _write(page, path, b"\x89PNG", f"--window-size={WINDOW[0]},{WINDOW[1]}", "--screenshot")


def _write(page: Path, path: Path, magic: bytes, *options: str) -> None:
    """Let the browser write a file that begins so; the last option takes its name."""
    browser = check_browser()

    def write(partial: Path) -> None:
        with temporary_folder() as folder:
            made = folder / path.name
            command = [browser, *FLAGS, f"--user-data-dir={folder / 'profile'}", *options]
            command[-1] += f"={made}"
            _run([*command, page.resolve().as_uri()])
            if not made.is_file() or not made.read_bytes().startswith(magic):
                raise InputError(f"{browser} made no {path.name} of {page}; print the page by hand.")
            shutil.copyfile(made, partial)

    write_whole(path, write)


def _run(command: list[str]) -> None:
    try:
        subprocess.run(command, check=True, capture_output=True, timeout=LONGEST_S)
    except subprocess.TimeoutExpired:
        raise InputError(f"{command[0]} did not print the page in {LONGEST_S} s; print it by hand.") from None
    except subprocess.CalledProcessError as error:
        told = error.stderr.decode(errors="replace").strip().splitlines()
        reason = told[-1] if told else f"exit code {error.returncode}"
        raise InputError(f"{command[0]} did not print the page ({reason}); print it by hand.") from None


def main() -> int:
    """Take the picture; 2 where there is no browser or no page."""
    parser = argparse.ArgumentParser(description=write_picture.__doc__)
    parser.add_argument("page", type=Path)
    parser.add_argument("picture", type=Path)
    arguments = parser.parse_args()
    try:
        if not arguments.page.is_file():
            raise InputError(f"There is no page {arguments.page}; run `gtm-fmu study` first.")
        write_picture(arguments.page, arguments.picture)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
