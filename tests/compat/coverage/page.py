"""The totals of `usdsdg compat` in docs/compatibility.md; `python -m tests.compat.coverage.page` rewrites them."""

import re
from pathlib import Path

from usdsdg.compat.coverage.board import board_text

PAGE = Path(__file__).resolve().parents[3] / "docs" / "compatibility.md"
SECTION = re.compile(r"(?<=\n## Totals\n\n).*?(?=\n## )", re.DOTALL)


def rewritten(text: str) -> str:
    """Return the text of the page with the section of totals as the command prints them."""
    table, _, sentence = board_text().rpartition("\n\n")
    return SECTION.sub(lambda _: f"{sentence}\n\n{table}\n", text)


if __name__ == "__main__":
    PAGE.write_text(rewritten(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    print(board_text())
