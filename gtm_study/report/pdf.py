"""The page of the study as PDF, which headless Chromium prints."""

import shutil
import subprocess
from pathlib import Path

from gtm_fmu.errors import InputError
from gtm_fmu.files import temporary_folder, write_whole

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
FLAGS = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-pdf-header-footer")
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
    browser = check_browser()

    def write(partial: Path) -> None:
        with temporary_folder() as profile:
            command = [browser, *FLAGS, f"--user-data-dir={profile}", f"--print-to-pdf={partial.resolve()}"]
            _run([*command, page.resolve().as_uri()])
        if not partial.is_file() or not partial.read_bytes().startswith(b"%PDF"):
            raise InputError(f"{browser} printed no PDF of {page}; print the page from a browser.")

    write_whole(path, write)


def _run(command: list[str]) -> None:
    try:
        subprocess.run(command, check=True, capture_output=True, timeout=LONGEST_S)
    except subprocess.TimeoutExpired:
        raise InputError(f"{command[0]} did not print the PDF in {LONGEST_S} s; print the page by hand.") from None
    except subprocess.CalledProcessError as error:
        told = error.stderr.decode(errors="replace").strip().splitlines()
        reason = told[-1] if told else f"exit code {error.returncode}"
        raise InputError(f"{command[0]} did not print the PDF ({reason}); print the page by hand.") from None
