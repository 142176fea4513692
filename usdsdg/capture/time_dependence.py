"""Whether what a stage shows depends on the time, so that frames which are drawn together cannot be captured so."""

from pxr import Usd, UsdPhysics

from usdsdg.errors import Unsupported
from usdsdg.session import engines
from usdsdg.session.settings.store import captures_on_play
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


def may_move(stage: Usd.Stage) -> bool:
    """Return whether bodies or time samples may change what the stage shows while the timeline plays, if it does.

    Without a renderer; time samples that no ray meets count, too.
    """
    if not (get_timeline().is_playing() or captures_on_play()):
        return False
    if any(layer.ListAllTimeSamples() for layer in stage.GetUsedLayers()):
        return True
    return any(prim.HasMetadata("clips") or prim.HasAPI(UsdPhysics.RigidBodyAPI) for prim in _every_prim(stage))


def _every_prim(stage: Usd.Stage) -> Usd.PrimRange:
    return Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate))


def _moving(stage: Usd.Stage) -> str:
    """Return what changes while the timeline plays; "" for nothing."""
    renderer = engines.renderer()
    renderer.sync(stage_time(stage))
    if not renderer.time.IsDefault():
        return "the stage is animated"
    body = next((prim for prim in _every_prim(stage) if prim.HasAPI(UsdPhysics.RigidBodyAPI)), None)
    return "" if body is None else f"{body.GetPath()} is a rigid body"
