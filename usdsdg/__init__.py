"""usdsdg: synthetic data from USD scenes, with the Replicator API.

`import usdsdg as rep` has the names of `import omni.replicator.core as rep` in Omniverse. The stub `__init__.pyi` lists
the public names by theme; each is imported on first use (PEP 562, as in SPEC 1 of Scientific Python), so that importing
`usdsdg.errors`, or one engine, imports nothing else. With EAGER_IMPORT in the environment all are imported at once.
"""

import ast
import importlib
import os
import sys
from functools import partial
from pathlib import Path
from typing import Any

__version__ = "0.2.0"

_FOREIGN = ("omni", "carb", "isaacsim", "usdrt")


def _working_folder() -> str:
    """Return the working directory; "" if it was removed."""
    try:
        return os.getcwd()
    except OSError:
        return ""


_STARTED_IN = _working_folder()  # before a script may leave it: paths that are printed are typed there


def _main_source() -> tuple[str, bytes] | None:
    """Return the path and content of the program that Python runs; None where it is no file of a usual size."""
    file = getattr(sys.modules.get("__main__"), "__file__", None)
    try:
        if not file or not file.endswith(".py") or os.stat(file).st_size > 1 << 20:
            return None
        with open(file, "rb") as opened:
            return file, opened.read()
    except OSError:
        return None


_MAIN_SOURCE = _main_source()  # of which a copy is kept beside the data: it may be edited before the first writer


def _public_names() -> dict[str, tuple[str, str]]:
    """Map each public name to (module, name in it), as the stub imports them."""
    stub = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    imports = [line for line in stub.body if isinstance(line, ast.ImportFrom)]
    return {
        alias.asname or alias.name: (f"usdsdg.{line.module}" if line.module else "usdsdg", alias.name)
        for line in imports
        for alias in line.names
    }


_PUBLIC = _public_names()
__all__ = list(_PUBLIC)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        from usdsdg.errors import MissingName

        raise AttributeError(MissingName(__name__, name, partial(_hint, name)), name=name, obj=sys.modules[__name__])
    module, original = _PUBLIC[name]
    if module == "usdsdg":
        return importlib.import_module(f"usdsdg.{original}")
    value = globals()[name] = getattr(importlib.import_module(module), original)
    return value


def _hint(name: str) -> str:
    from usdsdg.arguments.misplaced import hint

    return hint(__name__, name, __all__)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


def _announce_schemas() -> None:
    """Let USD find the schemas that usd-core lacks: it looks once, when a process makes its first stage.

    That may be before a module of ours has loaded pxr. Until then the environment tells (see `stage.schemas.register`).
    """
    if "pxr" in sys.modules:
        from usdsdg.stage import schemas

        schemas.register()
        return
    folders = sorted((Path(__file__).parent / "stage" / "schemas" / "resources").iterdir())
    before = os.environ.get("PXR_PLUGINPATH_NAME")
    os.environ["PXR_PLUGINPATH_NAME"] = os.pathsep.join([*(f"{each}/" for each in folders), *filter(None, [before])])


class _ForeignNames:
    """Says, where names of Omniverse are imported that nothing has brought, what brings them."""

    @staticmethod
    def find_spec(name: str, path: Any = None, target: Any = None) -> None:
        """Raise an error with a remedy for an import; programs that only ask whether there is a module get None."""
        asks = sys._getframe(2).f_code.co_name  # behind the loop over the finders
        if path is None and name in _FOREIGN and asks == "_find_and_load_unlocked":
            raise ModuleNotFoundError(
                f"No module named {name!r}. Run the program with `usdsdg run` to have the names of Omniverse and Isaac "
                "Sim. A notebook, and any other program, has them after `import usdsdg.compat; "
                "usdsdg.compat.install()`.",
                name=name,
            )


def _show_in_notebooks() -> None:
    """Let IPython, where it runs, show stages as trees."""
    if "IPython" in sys.modules:
        from usdsdg.notebook import formatters

        formatters.register()


_announce_schemas()
_show_in_notebooks()
sys.meta_path.append(_ForeignNames)
if os.environ.get("EAGER_IMPORT"):
    for _name in __all__:
        __getattr__(_name)
