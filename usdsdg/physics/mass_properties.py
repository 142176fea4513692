"""Mass properties of rigid bodies and colliders. Mirrors `rep.physics.mass`."""

from typing import Any

from pxr import Gf, Usd, UsdPhysics

from usdsdg.arguments.values import vector
from usdsdg.distribution import draw
from usdsdg.graph.actions import action
from usdsdg.graph.evaluate import act
from usdsdg.graph.node import Node, ReplicatorItem
from usdsdg.modify.numbers import draw_numbers
from usdsdg.modify.prims import target_prims
from usdsdg.stage.attribute_batch import write_batch

# Methods that create the attributes of MassAPI, by input.
_CREATE_ATTRIBUTE = {
    "mass": "CreateMassAttr",
    "density": "CreateDensityAttr",
    "centerOfMass": "CreateCenterOfMassAttr",
    "diagonalInertia": "CreateDiagonalInertiaAttr",
    "principalAxes": "CreatePrincipalAxesAttr",
}


def mass(
    mass: Any = None, density: Any = None, center_of_mass: Any = None, diagonal_inertia: Any = None,
    principal_axes: Any = None, input_prims: Any = None,
) -> ReplicatorItem:  # fmt: skip
    """Author mass properties at each execution; each is one value for all, a list of one per prim, or a distribution.

    Args:
        mass: in units of the stage's kilogramsPerUnit.
        density: mass per cubic stage unit; counts where there is no mass.
        center_of_mass: (x, y, z) in the prim's own space [stage units].
        diagonal_inertia: moments of inertia about the principal axes [mass × stage units²].
        principal_axes: rotation from the prim's axes to the principal ones, as a quaternion (w, x, y, z).

    Raises:
        GraphError: at execution, a value has another shape.
    """
    given = dict(
        mass=mass, density=density, centerOfMass=center_of_mass, diagonalInertia=diagonal_inertia,
        principalAxes=principal_axes,
    )  # fmt: skip
    return act("OgnMass", input_prims, attribute="mass", **given)


@action("OgnMass", *_CREATE_ATTRIBUTE)
def _write_mass(node: Node, execution: int) -> None:
    for name, value in node.inputs.items():
        if name in _CREATE_ATTRIBUTE:
            scalar = name in ("mass", "density")
            drawn = draw_numbers(name, node, execution).tolist() if scalar else draw(value, node, execution, name)
            _write_mass_property(node, name, drawn)


def _write_mass_property(node: Node, name: str, values: list[Any]) -> None:
    def find() -> list[Usd.Attribute]:
        return [getattr(UsdPhysics.MassAPI.Apply(prim), _CREATE_ATTRIBUTE[name])() for prim in target_prims(node)]

    if name != "principalAxes" and write_batch(node.state, name, find, values):
        return
    for attribute, value in zip(find(), values):
        attribute.Set(_mass_value(name, value))


def _mass_value(name: str, value: Any) -> Any:
    if name == "principalAxes":
        w, *xyz = vector("principal_axes", value, 4)
        return Gf.Quatf(w, Gf.Vec3f(xyz)).GetNormalized()
    arguments = {"centerOfMass": "center_of_mass", "diagonalInertia": "diagonal_inertia"}
    return Gf.Vec3f(vector(arguments[name], value)) if name in arguments else float(value)
