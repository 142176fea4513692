import json
import subprocess
import sys
from pathlib import Path

import pytest
from pxr import Sdf, Usd, UsdGeom, UsdPhysics

import usdsdg
from usdsdg.stage import schemas
from usdsdg.stage.schemas import physx as PhysxSchema
from usdsdg.stage.schemas.semantics_schema import SemanticsAPI

# The tests run against the checkout as well as against an installed package.
SOURCE = str(Path(schemas.__file__).parents[3])

SINGLE = [name for name in PhysxSchema.__all__ if not hasattr(getattr(PhysxSchema, name), "GetAll")]
MULTIPLE = sorted(set(PhysxSchema.__all__) - set(SINGLE))


@pytest.fixture
def stage():
    return Usd.Stage.CreateInMemory()


@pytest.fixture
def prim(stage):
    return UsdGeom.Cube.Define(stage, "/World/cube").GetPrim()


def test_the_names_that_scripts_use_exist():
    wanted = """PhysxSceneAPI PhysxRigidBodyAPI PhysxCollisionAPI PhysxMaterialAPI PhysxConvexHullCollisionAPI
        PhysxConvexDecompositionCollisionAPI PhysxTriangleMeshCollisionAPI PhysxSDFMeshCollisionAPI
        PhysxArticulationAPI PhysxJointAPI PhysxContactReportAPI PhysxTriggerAPI PhysxLimitAPI JointStateAPI"""
    assert set(wanted.split()) <= set(PhysxSchema.__all__)
    with pytest.raises(AttributeError, match=r"PhysxVehicleAPI.*PhysxSceneAPI"):
        PhysxSchema.PhysxVehicleAPI  # noqa: B018
    assert not hasattr(PhysxSchema, "PhysxParticleSystem")


@pytest.mark.parametrize("name", SINGLE)
def test_single_apply_schemas(stage, prim, name):
    api = getattr(PhysxSchema, name)
    assert not prim.HasAPI(api)
    assert not api(prim)
    assert api.CanApply(prim)
    applied = api.Apply(prim)
    assert applied
    assert prim.HasAPI(api)
    assert applied.GetPrim() == prim
    assert applied.GetPath() == prim.GetPath()
    assert applied == api.Get(stage, "/World/cube")
    assert not api.Get(stage, "/World/nothing")
    assert name in prim.GetAppliedSchemas()
    assert stage.GetRootLayer().GetPrimAtPath("/World/cube").GetInfo("apiSchemas").prependedItems == [name]


@pytest.mark.parametrize("name", MULTIPLE)
def test_multiple_apply_schemas(prim, name):
    api = getattr(PhysxSchema, name)
    identifier = "PhysicsJointStateAPI" if name == "JointStateAPI" else name
    applied = api.Apply(prim, "angular")
    assert applied
    assert applied.GetName() == "angular"
    assert prim.HasAPI(api, "angular")
    assert not prim.HasAPI(api, "linear")
    assert not api(prim, "linear")
    assert api.GetAll(prim) == [applied]
    assert f"{identifier}:angular" in prim.GetAppliedSchemas()


@pytest.mark.parametrize("name", PhysxSchema.__all__)
def test_every_property_has_a_getter_a_creator_and_its_fallback(prim, name):
    api = getattr(PhysxSchema, name)
    applied = api.Apply(prim, "x") if name in MULTIPLE else api.Apply(prim)
    definition = prim.GetPrimDefinition()
    for api_name, item in applied._table.items():
        full_name = item.on("x" if name in MULTIPLE else None)
        suffix = "Attr" if item.type_name else "Rel"
        got = getattr(applied, f"Get{api_name}{suffix}")()
        assert got
        assert got.GetName() == full_name
        assert getattr(applied, f"Create{api_name}{suffix}")() == got
        if item.type_name:
            assert got.GetTypeName() == item.type_name == definition.GetSchemaAttributeSpec(full_name).typeName
            assert not got.IsCustom()
            fallback = got.Get()
            tokens = definition.GetSchemaAttributeSpec(full_name).allowedTokens
            assert not tokens or fallback is None or fallback in tokens


@pytest.mark.parametrize(
    ("name", "getter", "value"),
    [
        ("PhysxSceneAPI", "GetTimeStepsPerSecondAttr", 60),
        ("PhysxSceneAPI", "GetSolverTypeAttr", "TGS"),
        ("PhysxRigidBodyAPI", "GetDisableGravityAttr", False),
        ("PhysxRigidBodyAPI", "GetAngularDampingAttr", pytest.approx(0.05)),
        ("PhysxRigidBodyAPI", "GetMaxLinearVelocityAttr", float("inf")),
        ("PhysxRigidBodyAPI", "GetSolverPositionIterationCountAttr", 16),
        ("PhysxCollisionAPI", "GetContactOffsetAttr", float("-inf")),
        ("PhysxMaterialAPI", "GetFrictionCombineModeAttr", "average"),
        ("PhysxConvexHullCollisionAPI", "GetHullVertexLimitAttr", 64),
        ("PhysxConvexDecompositionCollisionAPI", "GetMaxConvexHullsAttr", 32),
        ("PhysxSDFMeshCollisionAPI", "GetSdfResolutionAttr", 256),
        ("PhysxTriangleMeshSimplificationCollisionAPI", "GetSimplificationMetricAttr", pytest.approx(0.55)),
    ],
)
def test_documented_defaults_are_read_without_authoring(stage, prim, name, getter, value):
    api = getattr(PhysxSchema, name).Apply(prim)
    assert getattr(api, getter)().Get() == value
    assert not stage.GetRootLayer().GetPrimAtPath("/World/cube").attributes


def test_create_authors_and_sparsely_only_what_differs(stage, prim):
    api = PhysxSchema.PhysxRigidBodyAPI.Apply(prim)
    spec = stage.GetRootLayer().GetPrimAtPath("/World/cube")
    api.CreateDisableGravityAttr(False, True)
    assert "physxRigidBody:disableGravity" not in spec.attributes
    api.CreateDisableGravityAttr(True, writeSparsely=True)
    assert spec.attributes["physxRigidBody:disableGravity"].default is True
    api.CreateAngularDampingAttr(0.0)
    assert spec.attributes["physxRigidBody:angularDamping"].default == 0.0
    api.CreateSolverPositionIterationCountAttr().Set(8)
    assert api.GetSolverPositionIterationCountAttr().Get() == 8
    assert not spec.attributes["physxRigidBody:angularDamping"].custom


def test_time_steps_accept_what_scripts_compute(stage):
    api = PhysxSchema.PhysxSceneAPI.Apply(UsdPhysics.Scene.Define(stage, "/PhysicsScene").GetPrim())
    api.GetTimeStepsPerSecondAttr().Set(1 / 0.025 * 8)
    assert api.GetTimeStepsPerSecondAttr().Get() == 320


def test_methods_can_be_called_on_the_class_too(prim):
    api = PhysxSchema.PhysxCollisionAPI.Apply(prim)
    PhysxSchema.PhysxCollisionAPI.CreateRestOffsetAttr(api, 0.25)
    assert PhysxSchema.PhysxCollisionAPI.GetRestOffsetAttr(api).Get() == 0.25


def test_schemas_mix_with_usd_physics(stage, prim):
    UsdPhysics.RigidBodyAPI.Apply(prim)
    PhysxSchema.PhysxRigidBodyAPI.Apply(prim)
    UsdPhysics.CollisionAPI.Apply(prim)
    PhysxSchema.PhysxCollisionAPI(UsdPhysics.CollisionAPI(prim)).CreateContactOffsetAttr(0.1)
    assert prim.GetAppliedSchemas() == ["PhysicsRigidBodyAPI", "PhysxRigidBodyAPI", "PhysicsCollisionAPI"]
    assert not prim.HasAPI(PhysxSchema.PhysxCollisionAPI)
    PhysxSchema.PhysxCollisionAPI.Apply(prim)
    assert prim.HasAPI(UsdPhysics.RigidBodyAPI)
    prim.RemoveAPI(PhysxSchema.PhysxRigidBodyAPI)
    assert not prim.HasAPI(PhysxSchema.PhysxRigidBodyAPI)
    assert prim.HasAPI(UsdPhysics.RigidBodyAPI)


def test_collections_and_relationships(stage, prim):
    PhysxSchema.PhysxMeshMergeCollisionAPI.Apply(prim)
    assert Usd.CollectionAPI(prim, "collisionmeshes").GetIncludesRel()
    report = PhysxSchema.PhysxContactReportAPI.Apply(prim)
    report.CreateReportPairsRel().AddTarget("/World")
    assert report.GetReportPairsRel().GetTargets() == [Sdf.Path("/World")]


def test_saved_files_hold_plain_names(stage, prim):
    PhysxSchema.PhysxRigidBodyAPI.Apply(prim).CreateDisableGravityAttr(True)
    SemanticsAPI.Apply(prim, "Semantics").CreateSemanticDataAttr("mug")
    text = stage.GetRootLayer().ExportToString()
    assert 'prepend apiSchemas = ["PhysxRigidBodyAPI", "SemanticsAPI:Semantics"]' in text
    assert "bool physxRigidBody:disableGravity = 1" in text
    assert 'string semantic:Semantics:params:semanticData = "mug"' in text
    assert "usdsdg" not in text


def test_files_of_other_programs_are_recognized(stage):
    stage.GetRootLayer().ImportFromString(
        """#usda 1.0
        def PhysicsScene "scene" (prepend apiSchemas = ["PhysxSceneAPI"]) {
            uint physxScene:timeStepsPerSecond = 120
        }
        def Scope "joint" (prepend apiSchemas = ["PhysicsJointStateAPI:angular", "PhysxVehicleAPI"]) {}"""
    )
    scene = PhysxSchema.PhysxSceneAPI.Get(stage, "/scene")
    assert scene
    assert scene.GetTimeStepsPerSecondAttr().Get() == 120
    assert scene.GetGpuMaxNumPartitionsAttr().Get() == 8
    assert PhysxSchema.JointStateAPI.GetAll(stage.GetPrimAtPath("/joint"))


def test_instances_of_the_label_schema(stage, prim):
    api = SemanticsAPI.Apply(prim, "Semantics_a")
    assert api.GetPath() == "/World/cube.semantic:Semantics_a"
    assert SemanticsAPI.Get(stage, api.GetPath()) == SemanticsAPI.Get(prim, "Semantics_a") == api
    api.CreateSemanticTypeAttr("class")
    assert SemanticsAPI.IsSemanticsAPIPath(api.GetSemanticTypeAttr().GetPath())
    assert not SemanticsAPI.IsSemanticsAPIPath(Sdf.Path("/World/cube.size"))
    assert repr(api) == "SemanticsAPI(Usd.Prim(</World/cube>), 'Semantics_a')"


def test_objects_of_schemas_compare_by_prim_schema_and_name(stage, prim):
    other = stage.DefinePrim("/World/other")
    a, b = (PhysxSchema.PhysxRigidBodyAPI.Apply(each) for each in (prim, other))
    assert a != b
    assert a != PhysxSchema.PhysxCollisionAPI(prim)
    assert len({a, b, PhysxSchema.PhysxRigidBodyAPI(prim)}) == 2
    assert not PhysxSchema.PhysxRigidBodyAPI()
    assert PhysxSchema.PhysxRigidBodyAPI().GetPath() == Sdf.Path()


def run_python(code):
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env={"PYTHONPATH": SOURCE}, check=False
    )


def test_a_process_of_its_own_registers_before_first_use():
    done = run_python(
        "import usdsdg.session.stage_context as c, usdsdg.stage.schemas.physx as P\n"
        "p = c.new_stage().DefinePrim('/a', 'Cube')\n"
        "print(p.HasAPI(P.PhysxRigidBodyAPI), bool(P.PhysxRigidBodyAPI.Apply(p)), p.HasAPI(P.PhysxRigidBodyAPI),"
        " p.GetAttribute('physxRigidBody:solverVelocityIterationCount').Get())"
    )
    assert done.stdout.split() == ["False", "True", "True", "1"], done.stderr


def test_registering_too_late_is_an_error():
    done = run_python(
        "from pxr import Usd\n"
        "stage = Usd.Stage.CreateInMemory()\n"
        "stage.DefinePrim('/a', 'Cube').GetAttribute('size').Get()\n"
        "import usdsdg.session.stage_context"
    )
    assert "StageError" in done.stderr
    assert "before the first use" in done.stderr


def test_plugin_files_and_schema_files_agree():
    for folder in schemas.RESOURCES.iterdir():
        types = json.loads((folder / "plugInfo.json").read_text())["Plugins"][0]["Info"]["Types"]
        layer = Sdf.Layer.FindOrOpen(str(folder / "generatedSchema.usda"))
        declared = {kind["schemaIdentifier"]: kind for kind in types.values()}
        assert set(declared) == {prim.name for prim in layer.rootPrims}
        for prim in layer.rootPrims:
            multiple = declared[prim.name]["schemaKind"] == "multipleApplyAPI"
            assert all(("__INSTANCE_NAME__" in prop.name) == multiple for prop in prim.properties)


def test_usdsdg_is_the_package_under_test():
    assert Path(usdsdg.__path__[0]) == Path(SOURCE) / "usdsdg"
