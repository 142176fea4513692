"""What is read of a prim that has points: at which time, with which texture coordinates, parts and colors."""

from __future__ import annotations

from dataclasses import dataclass

from pxr import Sdf, Usd, UsdGeom

from usdsdg_render.usd.prim_kinds import IGNORED_PREFIXES, kind_of


@dataclass(frozen=True)
class PrimSurface:
    """The surface of a mesh, a patch, curves or points, as the materials of its slots read it.

    Attributes:
        uv_names: primvar of the texture coordinates: none where any will do, one for all material slots, or one for
            each.
        subsets: GeomSubsets with a material of their own, in the order of the slots.
        colored: material slots that show displayColor and displayOpacity that vary over the surface.
    """

    prim: Usd.Prim
    time: Usd.TimeCode
    uv_names: tuple[str, ...] = ()
    subsets: tuple[Usd.Prim, ...] = ()
    colored: tuple[int, ...] = ()

    @property
    def kind(self) -> int:
        """The kind of the prim: MESH, PATCH, CURVES or POINTS of `prim_kinds`."""
        return kind_of(self.prim)

    @property
    def path(self) -> str:
        """The path of the prim."""
        return str(self.prim.GetPath())

    def specs(self) -> tuple:
        """Return a key that is equal for surfaces composed of the same specs: these are the same at one time."""
        inherited = tuple(_inherited_uvs(self.prim, name) for name in self.uv_names)
        own = (_specs(each) for each in (self.prim, *self.subsets))
        return (self.kind, self.uv_names, self.colored, inherited, *own)


def _specs(prim: Usd.Prim) -> tuple:
    """Return the (layer, path) of the specs of a prim that may affect its geometry, not only its physics or labels."""
    return tuple((spec.layer.identifier, spec.path) for spec in prim.GetPrimStack() if _affects_geometry(spec))


def _inherited_uvs(prim: Usd.Prim, uv_name: str) -> str:
    """Return where the texture coordinates are that a mesh inherits from a prim above; "" for its own, or none."""
    if not uv_name or prim.HasAttribute(f"primvars:{uv_name}"):
        return ""
    inherited = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(uv_name)
    return str(inherited.GetAttr().GetPath()) if inherited else ""


def _affects_geometry(spec: Sdf.PrimSpec) -> bool:
    return any(not name.startswith(IGNORED_PREFIXES) for name in spec.properties.keys())  # noqa: SIM118
