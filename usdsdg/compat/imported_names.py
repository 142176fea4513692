"""Names that modules of Isaac Sim import, and that scripts take from there: `prims.get_current_stage`."""

from __future__ import annotations

_UTILS = "isaacsim.core.utils"
# Where the names are defined; the modules below import them in Isaac Sim.
_DEFINED = {
    f"{_UTILS}.stage": "get_current_stage get_current_stage_id get_stage_units traverse_stage update_stage",
    f"{_UTILS}.prims": "define_prim find_matching_prim_paths get_all_matching_child_prims "
    "get_first_matching_child_prim get_prim_at_path get_prim_children get_prim_parent get_prim_path "
    "get_prim_property get_prim_type_name "
    "is_prim_ancestral is_prim_non_root_articulation_link is_prim_path_valid is_prim_root_path move_prim "
    "set_prim_property",
    f"{_UTILS}.semantics": "add_labels add_update_semantics",
    f"{_UTILS}.string": "find_unique_string_name",
    f"{_UTILS}.rotations": "gf_quat_to_np_array",
    f"{_UTILS}.xforms": "get_local_pose get_world_pose",
    f"{_UTILS}.types": "ArticulationActions XFormPrimViewState",
    "isaacsim.storage.native": "get_assets_root_path get_assets_root_path_async",
    "isaacsim.core.simulation_manager": "IsaacEvents SimulationManager",
    "isaacsim.core.rendering_manager": "RenderingManager",
    "isaacsim.core.prims": "Articulation GeometryPrim RigidPrim SingleArticulation SingleGeometryPrim SingleRigidPrim "
    "SingleXFormPrim XFormPrim",
    "isaacsim.core.api.materials": "PhysicsMaterial PreviewSurface VisualMaterial",
    "isaacsim.core.api.robots": "Robot RobotView",
    "isaacsim.core.api.sensors": "BaseSensor RigidContactView",
    "isaacsim.core.api": "SimulationContext",
    "isaacsim.core.experimental.utils": "backend_utils=backend foundation_utils=foundation ops_utils=ops "
    "prim_utils=prim stage_utils=stage",
    "isaacsim.core.experimental.prims": "XformPrim",
    "omni.replicator.core": "AnnotatorRegistry BackendDispatch Writer WriterRegistry F=functional",
    "omni.replicator.core.backends": "BackendGroup BaseBackend",
    "omni.syntheticdata": "SyntheticData",
    "omni.behavior.scripting.core": "BehaviorScript",
}
_PLACES = {
    new: (module, old or new)
    for module, names in _DEFINED.items()
    for new, _, old in (name.partition("=") for name in names.split())
}
_OBJECTS = (
    "PhysicsMaterial PreviewSurface VisualMaterial SingleGeometryPrim SingleRigidPrim get_prim_at_path "
    "is_prim_path_valid get_current_stage find_unique_string_name"
)
# By the module, below `usdsdg.compat`, the names that Isaac Sim's module of that name imports.
_IMPORTED = {
    f"{_UTILS}.articulations": "get_current_stage",
    f"{_UTILS}.bounds": "get_prim_at_path",
    f"{_UTILS}.mesh": "get_stage_units",
    f"{_UTILS}.physics": "get_current_stage",
    f"{_UTILS}.prims": "add_labels add_update_semantics get_current_stage get_current_stage_id",
    f"{_UTILS}.render_product": "get_current_stage",
    f"{_UTILS}.semantics": "get_current_stage",
    f"{_UTILS}.transformations": "gf_quat_to_np_array",
    f"{_UTILS}.viewports": "is_prim_path_valid get_current_stage",
    f"{_UTILS}.xforms": "get_prim_at_path get_prim_parent get_prim_path is_prim_path_valid",
    "isaacsim.sensors.camera.camera": "SimulationManager define_prim get_all_matching_child_prims get_prim_at_path "
    "get_prim_path get_prim_type_name is_prim_path_valid",
    "isaacsim.sensors.physics.contact_sensor": "BaseSensor SimulationManager get_prim_at_path is_prim_path_valid "
    "traverse_stage",
    "isaacsim.sensors.physics.imu_sensor": "BaseSensor SimulationManager get_prim_at_path is_prim_path_valid "
    "traverse_stage",
    **{f"isaacsim.core.api.objects.{name}": _OBJECTS for name in ("capsule", "cone", "cuboid", "cylinder", "sphere")},
    "isaacsim.core.api.objects.ground_plane": "get_first_matching_child_prim get_prim_path get_prim_type_name "
    "is_prim_path_valid get_current_stage get_stage_units find_unique_string_name",
    "isaacsim.core.api.materials.omni_glass": "get_prim_at_path is_prim_path_valid move_prim",
    "isaacsim.core.api.materials.omni_pbr": "get_prim_at_path is_prim_path_valid get_current_stage",
    "isaacsim.core.api.scenes.scene": "Robot RobotView RigidContactView Articulation GeometryPrim RigidPrim "
    "SingleArticulation SingleGeometryPrim SingleRigidPrim SingleXFormPrim XFormPrim get_prim_children "
    "get_prim_parent get_prim_path is_prim_ancestral is_prim_path_valid is_prim_root_path get_current_stage "
    "update_stage find_unique_string_name get_assets_root_path",
    "isaacsim.core.api.sensors.rigid_contact_view": "SimulationContext find_matching_prim_paths get_prim_at_path",
    "isaacsim.core.prims.articulation": "SimulationManager get_prim_at_path get_prim_parent get_prim_property "
    "set_prim_property ArticulationActions XFormPrimViewState XFormPrim",
    "isaacsim.core.prims.rigid_prim": "SimulationManager get_prim_parent",
    "isaacsim.core.prims.single_xform_prim": "define_prim get_prim_at_path is_prim_path_valid",
    "isaacsim.core.prims.xform_prim": "IsaacEvents SimulationManager get_prim_at_path get_prim_parent "
    "is_prim_non_root_articulation_link is_prim_path_valid get_current_stage get_local_pose get_world_pose",
    "isaacsim.core.experimental.objects.mesh": "XformPrim",
    "isaacsim.core.experimental.prims.articulation": "SimulationManager XformPrim",
    "isaacsim.core.experimental.prims.prim": "IsaacEvents SimulationManager",
    "isaacsim.core.experimental.prims.rigid_prim": "SimulationManager XformPrim",
    "isaacsim.core.experimental.utils.bounds": "stage_utils",
    "isaacsim.core.experimental.utils.prim": "foundation_utils stage_utils",
    "isaacsim.core.experimental.utils.semantics": "stage_utils",
    "isaacsim.core.experimental.utils.stage": "backend_utils prim_utils",
    "isaacsim.core.experimental.utils.transform": "ops_utils",
    "isaacsim.core.experimental.utils.xform": "ops_utils prim_utils stage_utils",
    "isaacsim.core.rendering_manager.viewport_manager": "RenderingManager",
    "isaacsim.replicator.writers": "AnnotatorRegistry BackendDispatch BackendGroup BaseBackend F SyntheticData Writer "
    "WriterRegistry",
    **{
        f"isaacsim.replicator.behavior.behaviors.{name}": "BehaviorScript"
        for name in (
            "example_behavior", "light_randomizer", "location_randomizer", "look_at_behavior", "rotation_randomizer",
            "texture_randomizer", "volume_stack_randomizer",
        )
    },
}  # fmt: skip


def place_of(real_module: str, name: str) -> tuple[str, str] | None:
    """Return the module that defines a name which Isaac Sim's module imports, and the name there; None for others.

    real_module: as `usdsdg.compat.isaacsim.core.utils.prims`.
    """
    imported = _IMPORTED.get(real_module.removeprefix("usdsdg.compat."), "")
    return _PLACES[name] if name in imported.split() else None


def importers() -> list[str]:
    """Return the modules of Isaac Sim of which imported names are known."""
    return list(_IMPORTED)


def imported_by(module: str) -> list[str]:
    """Return the names that a module of Isaac Sim imports and scripts may take from it."""
    return _IMPORTED[module].split()
