"""Mutated inputs: `python -m tests.soak inputs` changes small files of nine kinds and runs commands on them.

Stages (text, crate, package), textures (PNG, JPEG, HDR), configurations, Replicator graphs in YAML, and stages that
were saved with their graph. A failure is a process that dies or takes over 20 s, a traceback, an error that names no
file, and, of files with checksums (PNG, packages), another picture without an error or a warning. Elsewhere a mutation
may be a legitimate edit, such as a radius of 0.4 that becomes 0.5: it is counted as changed, and is no failure.
"""

from __future__ import annotations

import argparse
import re
import shutil
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from tests.soak.inputs.mutations import mutated
from tests.soak.inputs.originals import Original, originals
from tests.soak.meshes.workers import Worker

LIMIT = 20.0  # seconds
_PRIM = re.compile(r"(?<!\S)/[A-Za-z_]\w*")  # the path of a prim
FIRST_LIMIT = 120.0  # of the first request of a process, which may compile kernels


class Trials:
    """Mutates originals and looks at what becomes of them."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._output = folder / "out"
        self._worker = Worker(folder / "log.txt", "tests.soak.inputs.worker")
        self.originals = originals(folder / "originals", self._output)
        self._whole: dict[str, str] = {}  # the pictures of originals that are whole, by kind

    def run(self, original: Original, seed: int) -> tuple[str, str]:
        """Return what became of a mutation: a word, and a line where it is a failure."""
        whole = self._pictures(original)
        draw = np.random.default_rng([seed, 7])
        how, data = mutated(original.file.read_bytes(), original.file.suffix, draw)
        place = self._folder / "mutated"
        shutil.rmtree(place, ignore_errors=True)
        shutil.copytree(original.file.parent, place)
        (place / original.file.name).write_bytes(data)
        found = self._run(original, place, LIMIT)
        if problem := _problem(original, found, whole):
            return "failed", f"{original.kind} {seed} ({how}): {problem}"
        if found["code"]:
            return "refused", ""
        if found["pictures"] == whole:
            return "equal", ""
        return ("warned" if "warning:" in found["said"] else "changed"), ""

    def close(self) -> None:
        """End the process."""
        self._worker.close()

    def _pictures(self, original: Original) -> str:
        """Return the pictures that an original gives; raise SystemExit if it fails."""
        if original.kind not in self._whole:
            found = self._run(original, original.file.parent, FIRST_LIMIT)
            if found.get("code") != 0 or found["traceback"]:
                raise SystemExit(f"the whole {original.kind} failed: {found}")
            self._whole[original.kind] = found["pictures"]
        return self._whole[original.kind]

    def _run(self, original: Original, folder: Path, limit: float) -> dict[str, Any]:
        request = {"arguments": original.arguments(folder, self._output), "output": str(self._output)}
        found = self._worker.answer(request, limit)
        if "crashed" in found:  # the next request starts a process
            self._worker.answer({"arguments": self.originals[0].arguments(self.originals[0].file.parent, self._output),
                                 "output": str(self._output)}, FIRST_LIMIT)  # fmt: skip
        return found


def _problem(original: Original, found: dict[str, Any], whole: str) -> str:
    """Return what is wrong with an answer; "" if nothing is."""
    if "crashed" in found:
        return found["crashed"]
    if found["traceback"] or "Traceback (most recent" in found["said"]:
        return (found["traceback"] or found["said"]).strip().replace("\n", " | ")[-700:]
    if found["code"]:
        is_named = (
            original.file.name in found["said"] or original.opened in found["said"] or _PRIM.search(found["said"])
        )
        return "" if is_named else f"the error names no file: {found['said'].strip()[-300:]}"
    if original.has_checksums and found["pictures"] != whole and original.file.name not in found["said"]:
        return "another picture, without a word"
    return ""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", help="a kind, such as usdz")
    options = parser.parse_args()
    failures = 0
    with tempfile.TemporaryDirectory() as folder:
        trials = Trials(Path(folder))
        chosen = [each for each in trials.originals if options.only in (None, each.kind)]
        counts = {each.kind: Counter[str]() for each in chosen}
        for number in range(options.count):
            original = chosen[number % len(chosen)]
            word, line = trials.run(original, options.seed + number)
            counts[original.kind][word] += 1
            if line:
                failures += 1
                print(line, flush=True)
        trials.close()
    for kind, count in counts.items():
        print(f"{kind}: {', '.join(f'{number} {word}' for word, number in sorted(count.items()))}")
    print(f"{options.count} mutated inputs, {failures} failed")
    return int(failures > 0)
