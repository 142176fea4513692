"""Convert meshes in ten forms, whole and broken: `python -m tests.soak meshes` prints a row each.

The files are made by code, those in the packages that are installed, and those below `--models FOLDER`, such as a
checkout of mikedh/trimesh or an unpacked wheel of pymeshlab. Then files are mutated, seeded, and converted again: none
may crash, hang or end without a reason.
"""

import argparse
import random
import tempfile
from collections.abc import Iterator
from pathlib import Path

from tests.soak.meshes import made_gltf, made_plain, made_usdz  # noqa: F401 (they register their files)
from tests.soak.meshes.cases import MAKERS, Case
from tests.soak.meshes.sheet import save_sheets
from tests.soak.meshes.workers import Worker
from usdsdg.meshes.readers import SUFFIXES, USD

PICTURE = (160, 120)
LIMIT, LARGE_LIMIT, LARGE = 20.0, 120.0, 20_000_000  # seconds, and bytes of files that may take longer


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--models", type=Path, action="append", default=[], help="a folder with more mesh files")
    parser.add_argument("--only", default="", help="only files whose name contains this")
    parser.add_argument("--mutations", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0, help="of the mutations")
    parser.add_argument("--sheets", type=Path, help="folder for the contact sheets")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        worker = Worker(folder / "log.txt")
        cases = [make(folder / "made") for make in MAKERS] + [*_installed(), *_below(options.models)]
        cases = [case for case in cases if options.only in case.file.name]
        wrong, pictures = 0, []
        print("| file | form | size [m] | triangles | s | repairs, notes or reason |\n|---|---|---|---|---|---|")
        for index, case in enumerate(cases):
            limit = LARGE_LIMIT if case.file.stat().st_size > LARGE else LIMIT
            found = worker.ask(case.file, folder / f"out{index}", picture=True, limit=limit)
            problem = _problem(case, found)
            wrong += bool(problem)
            print(_row(case.file, found) + (f" **{problem}** |" if problem else " |"), flush=True)
            if "picture" in found:
                pictures.append((case.file.name, Path(found["picture"])))
        crashed = _mutate([case for case in cases if not case.refused], folder, worker, options.mutations, options.seed)
        worker.close()
        sheets = save_sheets(pictures, options.sheets, PICTURE) if options.sheets else []
    forms = {case.file.suffix.lower() for case in cases}
    print(f"\n{len(cases)} files in {len(forms)} forms, {len(pictures)} converted, {wrong} not as they should be")
    print(f"{options.mutations} mutated files, {crashed} crashed or hung", *sheets, sep="\n")
    return int(wrong > 0 or crashed > 0)


def _installed() -> Iterator[Case]:
    """Yield the mesh files of installed packages."""
    import newton
    import trimesh
    import warp

    for module in (newton, warp, trimesh):
        yield from _below([Path(str(module.__file__)).parent])


def _below(folders: list[Path]) -> Iterator[Case]:
    for folder in folders:
        for file in sorted(folder.rglob("*")):
            if file.is_file() and file.suffix.lower() in set(SUFFIXES) - set(USD):
                yield Case(file, refused=None)


def _problem(case: Case, found: dict) -> str:
    """Return what is not as the case says; "" if all is."""
    if "crashed" in found:
        return found["crashed"]
    if case.refused is not None and case.refused != ("refused" in found):
        return "should be refused" if case.refused else "should be converted"
    text = found.get("refused") or "; ".join(found["lines"])
    if case.says not in text:
        return f"says nothing of {case.says!r}"
    reason = found.get("refused", "")
    if reason and ("\n" in reason or case.file.name not in reason):
        return "the reason is not one line that names the file"
    return ""


def _row(file: Path, found: dict) -> str:
    seconds = f"{found.get('seconds', 0.0):.1f}"
    text = found.get("refused") or found.get("crashed") or "; ".join(found["lines"])
    text = text.replace(str(file.parent) + "/", "").replace("|", "/")
    if "size" not in found:
        return f"| {file.name} | {file.suffix[1:].lower()} | refused | | {seconds} | {text}"
    size = " x ".join(f"{each:.3g}" for each in found["size"])
    return f"| {file.name} | {file.suffix[1:].lower()} | {size} | {found['triangles']} | {seconds} | {text}"


def _mutate(cases: list[Case], folder: Path, worker: Worker, count: int, seed: int) -> int:
    """Convert files with some bytes that are others; return how many crashed or hung."""
    draws, crashed = random.Random(seed), 0
    sources = [case.file for case in cases if case.file.stat().st_size < 1_000_000]
    for number in range(count if sources else 0):
        source = draws.choice(sources)
        content = bytearray(source.read_bytes())
        for _ in range(draws.choice((1, 3, 10, 100))):
            content[draws.randrange(len(content))] = draws.randrange(256)
        if draws.random() < 0.2:
            del content[draws.randrange(len(content)) :]
        mutated = source.with_name(f"mutated_{number}{source.suffix}") if folder in source.parents else None
        mutated = mutated or folder / f"mutated_{number}{source.suffix}"
        mutated.write_bytes(content)
        found = worker.ask(mutated, folder / f"mutated_{number}", picture=False, limit=LIMIT)
        if "crashed" in found or "\n" in found.get("refused", ""):
            crashed += 1
            print(f"mutation {number} of {source.name}: {found.get('crashed') or found['refused']}", flush=True)
    return crashed
