"""Points of meshes, curves and point clouds that have velocities, by which they move between their samples."""

from pxr import Usd, UsdGeom, Vt

from usdsdg.errors import counted, warn_once

# Of these one sample is enough to make points move.
VELOCITIES = ("velocities", "accelerations")


def have_velocities(prim: Usd.Prim) -> bool:
    """Return whether velocities move the points of a gprim: they and the points have time samples."""
    velocities = prim.GetAttribute("velocities")
    return bool(velocities and velocities.GetNumTimeSamples() and prim.GetAttribute("points").GetNumTimeSamples())


def moved_points(prim: Usd.Prim, time: Usd.TimeCode) -> Vt.Vec3fArray | None:
    """Return the points at `time` as `UsdGeomPointBased.ComputePointsAtTime` does; None where nothing moves them.

    The last sample of the points is moved by its velocities, and by its accelerations if there are any. Velocities that
    have no sample at that time, or another number of values, move nothing (with a warning).
    """
    if time.IsDefault() or not have_velocities(prim):
        return None
    schema, code = UsdGeom.PointBased(prim), time.GetValue()
    points, velocities = schema.GetPointsAttr(), schema.GetVelocitiesAttr()
    sample = points.GetBracketingTimeSamples(code)[0]
    if velocities.GetBracketingTimeSamples(code)[0] != sample:
        warn_once(
            f"{prim.GetPath()}: its velocities have no sample at time code {sample:g}, at which its points have one, "
            f"so the points are interpolated. Author both at the same times."
        )
        return None
    counts = [len(attribute.Get(sample) or ()) for attribute in (points, velocities)]
    if counts[0] != counts[1]:
        warn_once(
            f"{prim.GetPath()}: at time code {sample:g} there are {counted(counts[0], 'point')} and "
            f"{counted(counts[1], 'velocity', 'velocities')}, so the points are interpolated. Author one for each."
        )
        return None
    return schema.ComputePointsAtTime(time, time)
