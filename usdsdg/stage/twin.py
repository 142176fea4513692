"""A second stage over the layers of a first one, to add a camera or lights that the first one never sees."""

from pxr import Sdf, Usd


def twin_of(stage: Usd.Stage) -> Usd.Stage:
    """Return another stage that shows what `stage` shows, with a copy of its session layer.

    Edits of that session layer change nothing of `stage`, and notify nobody who listens to it. Edits of other layers
    change both.
    """
    session = Sdf.Layer.CreateAnonymous("twin.usda")
    if (own := stage.GetSessionLayer()) is not None:
        # A copy, not a sublayer: USD reads metadata of the stage from the session layer alone.
        session.TransferContent(own)
    twin = Usd.Stage.OpenMasked(
        stage.GetRootLayer(), session, stage.GetPathResolverContext(), stage.GetPopulationMask()
    )
    twin.MuteAndUnmuteLayers(stage.GetMutedLayers(), [])
    twin.SetLoadRules(stage.GetLoadRules())
    twin.SetInterpolationType(stage.GetInterpolationType())
    return twin
