"""Scopes of Replicator: every function that puts something below `/Replicator` makes it a Scope."""

import numpy as np
import pytest
from pxr import Usd, UsdPhysics

import usdsdg as rep
from usdsdg.compat.isaacsim.replicator.randomization.rigid_bodies import MATERIALS, RigidBodies
from usdsdg.modify.mdl_materials import mdl_material
from usdsdg.randomizer.scatter import show_voxels
from usdsdg.stage.scopes import define_scope


def physics_materials(stage):
    UsdPhysics.CollisionAPI.Apply(stage.DefinePrim("/World/cube", "Cube"))
    RigidBodies(["/World/cube"]).write("material_properties", [0], np.ones((1, 3)))
    assert stage.GetPrimAtPath(MATERIALS).GetChildren()


MAKERS = {
    "objects": lambda stage: rep.create.cube(),
    "materials": lambda stage: rep.create.material_omnipbr(),
    "MDL": lambda stage: mdl_material("OmniGlass.mdl"),
    "voxels": lambda stage: show_voxels(stage, np.zeros((1, 3)), 1.0),
    "graph": lambda stage: rep.utils.get_graph(),
    "physics": physics_materials,
}


@pytest.mark.parametrize("maker", MAKERS)
def test_replicator_is_a_scope_whatever_is_made_first(stage, maker):
    MAKERS[maker](stage)
    assert stage.GetPrimAtPath("/Replicator").GetTypeName() == "Scope"


def test_prims_that_are_there_stay_as_they_are():
    stage = Usd.Stage.CreateInMemory()
    stage.DefinePrim("/Replicator", "Xform")
    define_scope(stage, "/Replicator/Looks/Wood")
    made = stage.GetPrimAtPath("/Replicator/Looks/Wood")
    kinds = [prim.GetTypeName() for prim in (made.GetParent().GetParent(), made.GetParent(), made)]
    assert kinds == ["Xform", "Scope", "Scope"]
