"""Whether what a stage shows depends on the time, so that frames which are drawn together cannot be captured so."""

from pxr import Usd, UsdPhysics

from usdsdg.errors import Unsupported
from usdsdg.session import engines
from usdsdg.session.settings_store import captures_on_play
from usdsdg.session.stage_context import current_stage
from usdsdg.session.timeline import get_timeline, stage_time


def check_time_independent(remedy: str = "") -> None:
    """Check that captured frames do not follow from each other.

    Raises:
        Unsupported: the timeline plays, or will where capture on play is set, and the stage has rigid bodies or is
            animated.
    """
    plays = get_timeline().is_playing() or captures_on_play()
    if plays and (what := _moving(current_stage())):
        raise Unsupported(f"worlds: the timeline plays and {what}, so frames follow from each other. {remedy}".strip())


def _moving(stage: Usd.Stage) -> str:
    """Return what changes while the timeline plays; "" for nothing."""
    renderer = engines.renderer()
    renderer.sync(stage_time(stage))
    if not renderer.time.IsDefault():
        return "the stage is animated"
    everything = Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)
    body = next((prim for prim in Usd.PrimRange.Stage(stage, everything) if prim.HasAPI(UsdPhysics.RigidBodyAPI)), None)
    return "" if body is None else f"{body.GetPath()} is a rigid body"
