"""A script for `usdsdg run`: run the tests of one file of Isaac Sim, and print a row for each.

Arguments: the file, and words of which the names of its tests must have one.
"""

import asyncio
import importlib.util
import sys
import traceback
from pathlib import Path
from types import ModuleType

# How the line of a result begins; the name of the test and what came of it follow, with tabs between.
ROW = "label test"


def run(file: Path, words: list[str]) -> None:
    """Run the tests one after the other in the application's event loop."""
    from tests.soak.isaac_tests import kit_test, ros

    kit_test.install()
    ros.install(file)
    module = _load(file)
    cases = [
        case(name)
        for case in vars(module).values()
        if isinstance(case, type) and issubclass(case, kit_test.AsyncTestCase) and case.__module__ == module.__name__
        for name in vars(case)
        if name.startswith("test") and (not words or any(word in name for word in words))
    ]
    _tasks.append(asyncio.ensure_future(_run_all(cases)))


_tasks: list[asyncio.Task] = []  # keeps them alive


async def _run_all(cases: list) -> None:
    for case in cases:
        result = "passed"
        try:
            await case.run_async()
        except Exception as error:  # noqa: BLE001 - tests fail by raising anything
            traceback.print_exc()
            result = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        print(f"{ROW}\t{case.name}\t{result}", flush=True)


def _load(file: Path) -> ModuleType:
    """Import a file as a module of the package that `ros.install` has made for its relative imports."""
    spec = importlib.util.spec_from_file_location(f"isaac_tests.{file.stem}", file)
    assert spec is not None
    assert spec.loader is not None
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[3]))
    run(Path(sys.argv[1]), sys.argv[2:])
