"""Read which contacts are reported: PhysxContactReportAPI."""

from pxr import Usd

from usdsdg_physics.parse.attributes import finite, value
from usdsdg_physics.parse.units import Units
from usdsdg_physics.scene.records import ContactReportSpec


def read_contact_report(prim: Usd.Prim, units: Units) -> ContactReportSpec:
    """Read a prim with PhysxContactReportAPI."""
    partners = prim.GetRelationship("physxContactReport:reportPairs")
    return ContactReportSpec(
        path=str(prim.GetPath()),
        threshold=max(0.0, finite(value(prim, "physxContactReport:threshold", 1.0), 1.0))
        * units.kilograms
        * units.meters,
        partners=tuple(str(path) for path in partners.GetTargets()) if partners else (),
    )
