"""Run the object-based tutorial script in the spellings of Isaac Sim 4.2, 5.1 and 6.0, and compare what it leaves.

`python -m tests.soak spellings --script FILE --assets-root DIR` takes the script in its 4.2 form, which is not part of
this repository, writes its other forms beside it in the output folder, and runs the three with one seed. All files must
be equal, byte for byte: labels, poses and pictures.
"""

import argparse
import hashlib
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

# What differs from the form before, in the order of the forms; each text must be there.
SPELLINGS: dict[str, dict[str, str]] = {
    "4.2": {},
    "5.1": {
        "from omni.isaac.core.utils.semantics import add_update_semantics, remove_all_semantics": (
            "from isaacsim.core.utils.semantics import add_labels, remove_labels"
        ),
        "from omni.isaac.nucleus import get_assets_root_path": (
            "from isaacsim.storage.native import get_assets_root_path"
        ),
        "add_update_semantics(prim, label)": 'add_labels(prim, labels=[label], instance_name="class")',
        "remove_all_semantics(prim)": "remove_labels(prim, include_descendants=True)",
        "remove_all_semantics(prim, recursive=True)": "remove_labels(prim, include_descendants=True)",
    },
    "6.0": {
        "from isaacsim.core.utils.semantics import add_labels, remove_labels": (
            "from isaacsim.core.experimental.utils.semantics import add_labels, remove_all_labels"
        ),
        'add_labels(prim, labels=[label], instance_name="class")': 'add_labels(prim, labels=[label], taxonomy="class")',
        "remove_labels(prim, include_descendants=True)": "remove_all_labels(prim, include_descendants=True)",
        "from omni.physx import get_physx_interface, get_physx_scene_query_interface": (
            "from omni.physics.core import get_physics_scene_query_interface, get_physics_simulation_interface"
        ),
        "from pxr import Gf, PhysxSchema,": "from pxr import Gf, PhysicsSchemaTools, PhysxSchema,",
        "GetPrimAtPath(hit.rigid_body)": "GetPrimAtPath(str(PhysicsSchemaTools.intToSdfPath(hit.rigid_body)))",
        "def on_physics_step(dt: float):": "def on_physics_step(dt, context):",
        "get_physx_scene_query_interface()": "get_physics_scene_query_interface()",
        "            False, # pass 'False' to indicate an 'overlap multiple' query.\n": "",
        "get_physx_interface().subscribe_physics_step_events(on_physics_step)": (
            "get_physics_simulation_interface().subscribe_physics_on_step_events("
            "pre_step=False, order=0, on_update=on_physics_step)"
        ),
        "    physx_sub.unsubscribe()\n": "",
    },
}


def main() -> int:
    options = _options()
    forms = _write_forms(options.script.read_text(encoding="utf-8"), options)
    with ThreadPoolExecutor(options.at_once) as pool:
        left = dict(zip(forms, pool.map(lambda form: _files_of(form, options), forms.values())))
    first = next(iter(left.values()))
    equal = all(files == first and files for files in left.values())
    for version, files in left.items():
        differ = sorted(name for name in files.keys() | first.keys() if files.get(name) != first.get(name))
        print(f"{version}: {len(files)} files, {len(differ)} unlike those of 4.2 {differ[:5] or ''}")
    return int(not equal)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--script", type=Path, required=True, help="the tutorial script in its 4.2 form")
    parser.add_argument("--assets-root", type=Path, required=True)
    parser.add_argument("--out", type=Path, default=Path("_out_spellings"))
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--at-once", type=int, default=1, help="how many forms run at the same time")
    parser.add_argument("--set", action="append", default=[], metavar="OLD=NEW", help="also replace this text")
    options = parser.parse_args()
    options.out, options.assets_root = options.out.resolve(), options.assets_root.resolve()
    return options


def _write_forms(text: str, options: argparse.Namespace) -> dict[str, Path]:
    """Write the script in every spelling; return the files by version."""
    for each in options.set:
        old, _, new = each.partition("=")
        text = _replaced(text, {old: new})
    forms = {}
    for version, differences in SPELLINGS.items():
        text = _replaced(text, differences)
        forms[version] = options.out / version / "script.py"
        forms[version].parent.mkdir(parents=True)
        forms[version].write_text(text, encoding="utf-8")
    return forms


def _replaced(text: str, differences: dict[str, str]) -> str:
    for old, new in differences.items():
        if old not in text:
            sys.exit(f"the script has no {old!r}: is it the tutorial's 4.2 form?")
        text = text.replace(old, new)
    return text


def _files_of(script: Path, options: argparse.Namespace) -> dict[str, str]:
    """Run a script in its folder; return the SHA-256 of every file that it leaves."""
    command = [sys.executable, "-m", "usdsdg", "run", "--device", options.device, "--seed", "5"]
    command += ["--assets-root", str(options.assets_root), str(script)]
    started = time.monotonic()
    with (script.parent / "log.txt").open("w") as log:
        code = subprocess.run(command, cwd=script.parent, stdout=log, stderr=log).returncode
    print(f"{script.parent.name}: exit {code}, {time.monotonic() - started:.0f} s", flush=True)
    own = {script, script.parent / "log.txt"}
    files = [path for path in script.parent.rglob("*") if path.is_file() and path not in own]
    return {str(path.relative_to(script.parent)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


if __name__ == "__main__":
    sys.exit(main())
