"""Read the names that `usdsdg/compat/GAPS.md` lists; `python -m tests.contracts.gaps` rewrites its last section."""

from __future__ import annotations

import re
from pathlib import Path

from tests.contracts import mirror

GAPS = Path(__file__).resolve().parents[2] / "usdsdg" / "compat" / "GAPS.md"
MISSING, DIFFERENT, UNBUILT = "Missing on purpose", "Different on purpose", "Not built yet"


def listed(section: str, text: str | None = None) -> list[str]:
    """Return the names in a section of GAPS.md: those in backticks in a row's first cell or before an item's colon."""
    text = GAPS.read_text(encoding="utf-8") if text is None else text
    _, _, rest = text.partition(f"## {section}\n")
    lines = re.split(r"^## ", rest, maxsplit=1, flags=re.MULTILINE)[0].splitlines()
    rows = [line.split("|")[1] for line in lines if line.startswith("| `")]
    items = [line.partition("`: ")[0] + "`" for line in lines if line.startswith("- `")]
    return [name for cell in rows + items for name in re.findall(r"`([^`]+)`", cell)]


def with_unbuilt(text: str) -> str:
    """Return `text` of GAPS.md with its last section rewritten from the current differences."""
    before, heading, _ = text.partition(f"## {UNBUILT}\n")
    on_purpose = set(listed(MISSING, text)) | set(listed(DIFFERENT, text))
    items = [f"- `{path}`: {what}" for path, what in mirror.differences().items() if path not in on_purpose]
    return f"{before}{heading}\n" + ("\n".join(items) or "Nothing.") + "\n"


if __name__ == "__main__":
    GAPS.write_text(with_unbuilt(GAPS.read_text(encoding="utf-8")), encoding="utf-8")
    found, total = mirror.differences(), len(mirror.names())
    missing = sum(what in (mirror.MISSING, mirror.REFUSES) for what in found.values())
    print(f"{total} names, {missing} missing ({missing / total:.1%}), {len(found) - missing} different")
