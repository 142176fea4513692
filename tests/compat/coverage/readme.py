"""The totals of `usdsdg compat` in README; `python -m tests.compat.coverage.readme` rewrites them."""

import re
from pathlib import Path

from usdsdg.compat.coverage.board import board_text

README = Path(__file__).resolve().parents[3] / "README.md"
SECTION = re.compile(r"(?<=\n## What is supported\n\n).*?(?=\n## )", re.DOTALL)


def rewritten(text: str) -> str:
    """Return the text of README with the section of totals as the command prints them."""
    table, _, sentence = board_text().rpartition("\n\n")
    more = "`usdsdg compat SCRIPT...` tells it for scripts, [docs/compatibility.md](docs/compatibility.md) in full."
    return SECTION.sub(lambda _: f"{sentence}\n{more}\n\n{table}\n", text)


if __name__ == "__main__":
    README.write_text(rewritten(README.read_text(encoding="utf-8")), encoding="utf-8")
    print(board_text())
