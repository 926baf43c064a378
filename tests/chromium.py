"""A browser, where Chromium is installed: what a page says of itself after its scripts have run."""

import html
import re
import shutil
import subprocess
from pathlib import Path

PROGRAM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
ABSENT = "no Chromium here"
WATCH = """<script>window.wrong = []; console.error = (...all) => wrong.push(all.join(" "));
window.onerror = (what, _, line) => { wrong.push(`${what}, line ${line}`); };</script>"""


def is_here() -> bool:
    return PROGRAM is not None


def said_by(page: str, question: str, folder: Path) -> str:
    """What an expression is on a page, as text, after everything on it has run; errors are in ``wrong``."""
    ask = f'<pre id="said"></pre><script>document.getElementById("said").textContent = {question};</script>'
    (folder / "page.html").write_text(WATCH + page + ask)
    flags = ["--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=1000", "--dump-dom"]
    command = [str(PROGRAM), *flags, f"--user-data-dir={folder}", (folder / "page.html").as_uri()]
    run = subprocess.run(command, capture_output=True, timeout=60)
    (found,) = re.findall(r'<pre id="said">(.*?)</pre>', run.stdout.decode(), flags=re.DOTALL)
    return html.unescape(found)
