"""Runs headless Chromium for the sheet: prints it as PDF, and lets tests look at it. It fetches nothing from a network."""

import io
import logging
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from quoin_tools.base.files import write_file

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
FLAGS = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
         "--disable-component-update", "--disable-sync", "--hide-scrollbars")  # fmt: skip
HOW = "install Chromium (Debian: apt-get install chromium), or open report.html in any browser and print it to a file"


class BrowserError(RuntimeError):
    """There is no PDF; the message is one line."""


def find():
    """Path of Chromium: $QUOIN_CHROMIUM, or the first of NAMES on the path; None without."""
    named = os.environ.get("QUOIN_CHROMIUM")
    return named or next((path for path in map(shutil.which, NAMES) if path), None)


def run(page, *arguments, timeout=120):
    """Opens a local page in Chromium with a new, empty profile. Returns its output and its text on stderr."""
    program = find()
    if program is None:
        raise BrowserError(f"no Chromium found: {HOW}")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command = [program, *FLAGS, f"--user-data-dir={profile}", *arguments, Path(page).resolve().as_uri()]
        try:
            done = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=timeout, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise BrowserError(f"{program}: {error}") from error
    if done.returncode:
        raise BrowserError(f"{program}: exit code {done.returncode}: {done.stderr.strip().splitlines()[-1:]}")
    return done.stdout, done.stderr


def attached(data, name, text):
    """Bytes of a PDF with a text as an attached file."""
    from pypdf import PdfReader, PdfWriter

    logging.getLogger("pypdf").setLevel(logging.ERROR)  # Chromium's count of objects, which it mends
    book, made = PdfWriter(), io.BytesIO()
    book.clone_document_from_reader(PdfReader(io.BytesIO(data)))
    book.add_attachment(name, text.encode("utf-8"))
    book.write(made)
    return made.getvalue()


def pdf(page, path, name=None, text=""):
    """Prints a local page; with a name, a text is attached to the PDF as a file."""
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "page.pdf"
        run(page, f"--print-to-pdf={made}", "--no-pdf-header-footer", "--print-to-pdf-no-header")
        if not made.is_file() or made.stat().st_size < 1000:
            raise BrowserError(f"{path}: Chromium wrote no PDF")
        data = made.read_bytes()
    write_file(path, attached(data, name, text) if name else data)


def screenshot(page, path, width=1000, height=1400):
    run(page, f"--screenshot={path}", f"--window-size={width},{height}")


def document(page, width=800):
    """The page after its scripts have run in a window so wide [px], and stderr, where console messages go."""
    return run(page, f"--window-size={width},900", "--dump-dom", "--virtual-time-budget=10000", "--enable-logging=stderr")
