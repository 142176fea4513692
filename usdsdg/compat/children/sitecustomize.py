"""Run by Python at its start, in processes of a script: foreign names are installed where one is imported.

Nothing is loaded before that, and a Python without usdsdg is left alone. It comes in the place of the environment's own
`sitecustomize`, which is run, too.
"""

import importlib.machinery
import importlib.util
import os
import sys

_ROOTS = ("omni", "carb", "usdrt", "isaacsim", "semantics", "Semantics", "video_encoding")
_SCHEMAS = ("pxr.PhysxSchema", "pxr.Semantics", "pxr.PhysicsSchemaTools", "pxr.OmniScriptingSchema")


class _AtFirstImport:
    """The last finder: it is asked for names that no other knows."""

    installs_foreign_names = True  # by which `usdsdg.compat.install` knows it, and takes its place

    @classmethod
    def find_spec(cls, name, path=None, target=None):
        if name.partition(".")[0] not in _ROOTS and name not in _SCHEMAS:
            return None
        sys.meta_path.remove(cls)  # before anything is imported that asks for such names itself
        try:
            from usdsdg import compat
            from usdsdg.compat.children import options
        except ModuleNotFoundError as error:
            if error.name != "usdsdg":
                raise
            return None
        compat.install()
        options.take()
        return importlib.util.find_spec(name)


def _run_own() -> None:
    """Run the `sitecustomize` that this one comes before."""
    here = os.path.dirname(os.path.abspath(__file__))
    others = [path for path in sys.path if os.path.abspath(path or os.curdir) != here]
    spec = importlib.machinery.PathFinder.find_spec("sitecustomize", others)
    if spec is not None and spec.loader is not None:
        spec.loader.exec_module(importlib.util.module_from_spec(spec))


sys.meta_path.append(_AtFirstImport)
_run_own()
