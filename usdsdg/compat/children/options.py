"""Options of `usdsdg run` in the processes that its script starts: an environment variable tells them.

The seed is not among them. Processes that share out the frames of a script and set no seed would all draw the same.
"""

from __future__ import annotations

import json
import os
from typing import Any

from usdsdg import errors
from usdsdg.session import devices, stage_context
from usdsdg.session.new_stages import NewStage
from usdsdg.session.script_processes import OPTIONS
from usdsdg.session.session import current
from usdsdg.session.settings.replicator_version import KEY
from usdsdg.session.settings.store import get_settings
from usdsdg.stage import assets
from usdsdg.stage.poses.transforms import meters_per_unit


def tell() -> None:
    """Let processes that are started from here on have the options of this one."""
    os.environ[OPTIONS] = json.dumps(_of_session())


def take() -> None:
    """Take the options of the process that started this one; nothing if it told none.

    Raises:
        RenderError, PhysicsError: a device is not there any more.
    """
    told: dict[str, Any] = json.loads(os.environ.get(OPTIONS) or "{}")
    if not told:
        return
    assets.set_assets_root(told["assets_root"])
    assets.set_maps(assets.PathMap(*each) for each in told["maps"])
    assets.set_units(lambda: meters_per_unit(stage_context.current_stage()))
    assets.set_on_missing(assets.OnMissing(told["missing_assets"]))
    errors.set_lenient(told["lenient"])
    get_settings().set(KEY, told["replicator"])
    stage_context.use_new_stages(NewStage(told["new_stage"]))
    devices.use_device(told["device"], physics=told["physics_device"])


def _of_session() -> dict[str, Any]:
    root, on_missing = assets.configured_root(), assets.get_on_missing()
    # What lists all missing assets is the end of the command, which a process of the script does not have.
    at_once = on_missing is assets.OnMissing.ERROR
    return {
        "assets_root": root if root is None or assets.scheme_of(root) else os.path.abspath(os.path.expanduser(root)),
        "maps": assets.get_maps(),
        "missing_assets": (assets.OnMissing.RAISE if at_once else on_missing).value,
        "lenient": errors.is_lenient(),
        "replicator": get_settings().get(KEY),
        "new_stage": current().new_stage_kind.value,
        "device": current().engines.device,
        "physics_device": current().engines.physics_device,
    }
