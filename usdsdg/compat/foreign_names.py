"""Names of Isaac Sim and Omniverse that are known and not here: what is out of scope, and what is elsewhere.

A module that is out of scope can be imported (see `placeholders`), since scripts import more than they use. The tables
hold prefixes: a row stands for the module, or the name in a module, and all below it. What exists in `usdsdg.compat`
comes first.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class OutOfScope:
    """A subject that usdsdg leaves out: its modules, what they are for, and what a script can do instead."""

    subject: str
    prefixes: tuple[str, ...]
    instead: str

    def message(self, name: str) -> str:
        """Return the message of the error for `name`, one of these modules or a name in it."""
        return f"{name}: {self.subject} out of scope of usdsdg. {self.instead}"


@dataclass(frozen=True)
class Moved:
    """A module, or a name in one, whose work is done elsewhere."""

    prefix: str
    where: str


def _row(subject: str, instead: str, prefixes: str) -> OutOfScope:
    return OutOfScope(subject, tuple(prefixes.split()), instead)


# Of OmniGraph's core, what makes nodes and looks into graphs.
_GRAPH_NAMES = (
    "AttributePortType AttributeRole AttributeType AttributeValueHelper BaseDataType Bundle "
    "BundleContainer Database DynamicAttributeAccess DynamicAttributeInterface "
    "ExecutionAttributeState ExtendedAttributeType GraphBackingType GraphContext GraphController "
    "GraphEvaluationMode GraphEvent GraphRegistry MetadataKeys NodeController NodeEvent NodeType "
    "ObjectLookup OmniGraphInspector PerNodeKeys PtrToPtrKind ReadOnlyError Severity "
    "ThreadsafetyTestUtils TupleType Type TypedValue _omni_graph_core cmds deregister_node_type "
    "get_global_orchestration_graphs get_global_orchestration_graphs_in_pipeline_stage get_node_type "
    "in_compute register_node_type register_python_node tests"
)

OUT_OF_SCOPE = (
    _row(
        "ROS and other message buses are",
        "Write files with a writer, and publish them from there.",
        "isaacsim.ros1 isaacsim.ros2 isaacsim.ucx isaacsim.hsb isaacsim.streaming omni.isaac.ros_bridge "
        "omni.isaac.ros2_bridge omni.isaac.ros2_bridge_humble omni.kit.livestream omni.services isaacsim.iot",
    ),
    _row(
        "models, planners and controllers of particular robots are",
        "Drive the joints of a robot with SingleArticulation or Articulation of isaacsim.core.prims: targets, efforts, "
        "Jacobians.",
        "isaacsim.robot isaacsim.robot_motion isaacsim.robot_setup isaacsim.cortex "
        "isaacsim.core.experimental.actuators isaacsim.core.api.tasks omni.isaac.core.tasks "
        "omni.isaac.franka omni.isaac.universal_robots "
        "omni.isaac.manipulators omni.isaac.wheeled_robots omni.isaac.motion_generation omni.isaac.motion_planning "
        "omni.isaac.lula omni.isaac.cortex omni.isaac.cortex_sync omni.isaac.quadruped omni.isaac.surface_gripper "
        "omni.isaac.dofbot omni.isaac.jetbot omni.isaac.kaya omni.isaac.dynamic_control omni.isaac.robot_assembler "
        "omni.isaac.robot_benchmark omni.isaac.robot_description_editor omni.isaac.gain_tuner omni.isaac.grasp_editor "
        "omni.isaac.articulation_inspector omni.isaac.physics_inspector omni.isaac.policy omni.isaac.gym "
        "omni.isaac.lab omni.isaac.lab_tasks omni.isaac.orbit isaacsim.physics.newton.tensors",
    ),
    _row(
        "import and export of other formats are",
        "Convert the asset to USD beforehand, and reference the USD file.",
        "isaacsim.asset omni.isaac.urdf omni.isaac.mjcf omni.importer.urdf omni.importer.mjcf omni.exporter.urdf "
        "omni.isaac.exporter omni.isaac.occupancy_map omni.isaac.conveyor omni.isaac.merge_mesh "
        "isaacsim.util.merge_mesh omni.kit.asset_converter omni.kit.tool.asset_importer omni.kit.tool.asset_exporter "
        "omni.scene.optimizer omni.asset_validator omni.kit.usd.collect",
    ),
    _row(
        "characters and navigation are",
        "Animate prims with time samples or skeletal animations in their USD files.",
        "isaacsim.replicator.agent isaacsim.replicator.incident isaacsim.replicator.mobility_gen "
        "isaacsim.replicator.experimental.mobility_gen omni.anim omni.replicator.character omni.replicator.agent "
        "omni.metropolis",
    ),
    _row(
        "windows, menus and input devices are",
        "There is no window; call the functions that its buttons would call.",
        "omni.ui omni.ui_query omni.appwindow omni.kit.ui omni.kit.ui_test omni.kit.uiapp omni.kit.window "
        "omni.kit.menu omni.kit.property omni.kit.widget omni.kit.hotkeys omni.kit.actions omni.kit.browser "
        "omni.kit.context_menu omni.kit.notification_manager omni.kit.manipulator omni.kit.quicklayout "
        "omni.kit.selection omni.kit.splash omni.kit.viewport.window omni.kit.viewport.menubar "
        "omni.kit.viewport.menubar.core omni.kit.viewport.registry omni.kit.viewport.manipulator omni.kit.widgets "
        "omni.kit.style omni.kit.variant omni.kit.tool.measure omni.kit.clipboard "
        "omni.rtx.window omni.example omni.debugdraw omni.isaac.debug_draw omni.isaac.ui omni.isaac.ui_template "
        "omni.isaac.menu omni.isaac.examples omni.isaac.examples_nodes omni.isaac.synthetic_recorder "
        "omni.replicator.ui omni.isaac.app carb.input carb.windowing carb.imgui isaacsim.gui isaacsim.app "
        "isaacsim.code_editor isaacsim.util.camera_inspector isaacsim.util.debug_draw isaacsim.util.physics "
        "isaacsim.examples isaacsim.replicator.synthetic_recorder isaacsim.replicator.examples.ui "
        "isaacsim.replicator.behavior.ui isaacsim.replicator.grasping.ui isaacsim.replicator.episode_recorder.ui "
        "isaacsim.sensors.camera.ui isaacsim.physics.newton.ui",
    ),
    _row(
        "lidar, radar, ultrasonic and effort sensors are",
        "The annotator `pointcloud` of a camera gives points, ContactSensor and IMUSensor of isaacsim.sensors.physics "
        "measure contacts and motion.",
        "isaacsim.sensors.rtx isaacsim.sensors.physx isaacsim.sensors.physics.EffortSensor "
        "isaacsim.sensors.experimental.rtx isaacsim.sensors.experimental.physics omni.isaac.range_sensor "
        "omni.isaac.RangeSensorSchema omni.isaac.isaac_sensor omni.isaac.IsaacSensorSchema "
        "omni.isaac.proximity_sensor omni.isaac.sensor.EffortSensor "
        "omni.isaac.sensor.LidarRtx omni.isaac.sensor.RotatingLidarPhysX "
        "omni.isaac.sensor.scripts.lidar_rtx omni.sensors omni.drivesim",
    ),
    _row(
        "the cameras of isaacsim.sensors.experimental.rtx are",
        "Use Camera or CameraView of isaacsim.sensors.camera, or annotators on a render product of a Camera prim, "
        "which has the lens.",
        "isaacsim.sensors.experimental.rtx.RtxCamera isaacsim.sensors.experimental.rtx.CameraSensor "
        "isaacsim.sensors.experimental.rtx.TiledCameraSensor isaacsim.sensors.experimental.rtx.StructuredLightCamera "
        "isaacsim.sensors.experimental.rtx.SingleViewDepthCameraSensor",
    ),
    _row(
        "neural reconstructions (NuRec) are",
        "Scenes are USD prims: meshes, curves, points, volumes of boxes.",
        "isaacsim.replicator.nurec_utils omni.nurec omni.rtx.nre",
    ),
    _row(
        "teleoperation, headsets and recorded episodes are",
        "Write poses as time samples, and labels with a writer.",
        "isaacsim.replicator.teleop isaacsim.replicator.episode_recorder isaacsim.xr omni.kit.xr omni.xr",
    ),
    _row(
        "deformable bodies, particles and fluids are",
        "Bodies are rigid; a deformation can be animated with time samples of the points.",
        "omni.physx.scripts.deformableUtils omni.physx.scripts.deformableMeshUtils omni.physx.scripts.particleUtils "
        "isaacsim.core.prims.ClothPrim isaacsim.core.prims.SingleClothPrim isaacsim.core.prims.DeformablePrim "
        "isaacsim.core.prims.SingleDeformablePrim isaacsim.core.prims.ParticleSystem "
        "isaacsim.core.prims.SingleParticleSystem isaacsim.core.experimental.prims.DeformablePrim "
        "isaacsim.core.experimental.materials.SurfaceDeformableMaterial "
        "isaacsim.core.experimental.materials.VolumeDeformableMaterial isaacsim.core.api.materials.DeformableMaterial "
        "isaacsim.core.api.materials.ParticleMaterial omni.physxdeformable omni.flowusd "
        "omni.physx.vehicle omni.physxvehicle",
    ),
    _row(
        "extensions, their packages and the profilers of Kit are",
        "Call the functions of the script directly, and install packages with pip.",
        "omni.ext omni.kit.test omni.kit.pipapi omni.kit.loop omni.kit.profiler omni.kit.mainwindow omni.kit.registry "
        "omni.kit.renderer omni.kit.collaboration omni.kit.raycast omni.kit.material.library omni.kit.material "
        "omni.kit.thumbnails omni.kit.extpath omni.kit.telemetry omni.kit.tagging omni.kit.search "
        "omni.kit.environment omni.kit.sequencer omni.kit.timeline.minibar omni.kit.stage_column "
        "omni.kit.usd_presenter omni.kit.usd.layers omni.log omni.structuredlog omni.resourcemonitor omni.stats "
        "omni.usdaudio omni.activity omni.hydra omni.rtx omni.gpu_foundation omni.gpu_foundation_factory omni.mdl "
        "omni.iray omni.warp omni.volume omni.pip omni.inspect omni.isaac.core_archive omni.isaac.ml_archive "
        "omni.isaac.throttling omni.isaac.window omni.isaac.tests isaacsim.core.throttling isaacsim.core.includes "
        "isaacsim.pip isaacsim.test.collection isaacsim.test.docstring carb.profiler "
        "carb.filesystem carb.launcher omni.fabric omni.physxfabric omni.convexdecomposition "
        "isaacsim.core.nodes omni.isaac.core_nodes",
    ),
    _row(
        "OmniGraph and nodes that scripts define are",
        "Register a Python function with rep.randomizer.register, or change the stage between calls of "
        "rep.orchestrator.step.",
        "omni.graph.action omni.graph.nodes omni.graph.scriptnode omni.graph.tools omni.graph.ui omni.graph.window "
        "omni.graph.bundle omni.graph.expression omni.graph.instancing omni.graph.examples omni.graph.test "
        + " ".join(f"omni.graph.core.{name}" for name in _GRAPH_NAMES.split()),
    ),
    _row(
        "browsers and servers of assets are",
        "Give a folder or a URL with `--assets-root`, or single prefixes with `--map`.",
        "omni.simready omni.kit.content omni.nucleus omni.usd_resolver omni.kit.usda_edit omni.kit.asset_browser",
    ),
    _row(
        "captions of pictures are",
        "Write them from labels: those of a frame are in the payload of a writer.",
        "isaacsim.replicator.caption omni.replicator.caption",
    ),
    _row(
        "scenes from the description files of omni.replicator.object are",
        "Describe them for `usdsdg generate`, or as a Replicator YAML file.",
        "omni.replicator.object isaacsim.replicator.object omni.replicator.composer",
    ),
)

MOVED = (
    Moved(
        "omni.isaac.synthetic_utils",
        "omni.replicator.core: annotators.get(name) for the data, writers.get(name) for files",
    ),
    Moved(
        "omni.replicator.isaac",
        "omni.replicator.core for its writers, isaacsim.replicator.domain_randomization for the rest",
    ),
    Moved(
        "omni.kit.capture",
        "omni.replicator.core: BasicWriter, or `usdsdg render` for a single picture",
    ),
    Moved(
        "omni.kit.viewport_widgets_manager",
        "omni.kit.viewport.utility",
    ),
    Moved(
        "omni.isaac.configurator",
        "omni.isaac.kit",
    ),
    Moved(
        "omni.isaac.shapenet",
        "references to the converted USD files: isaacsim.core.utils.stage.add_reference_to_stage",
    ),
    Moved(
        "omni.replicator.core.utils.AttrMap",
        "omni.replicator.core.modify.attribute, or prim.GetAttribute(name).Set(value)",
    ),
    Moved(
        "omni.replicator.core.randomizer.objects",
        "omni.replicator.core.randomizer.instantiate, which returns a population of assets",
    ),
    Moved(
        "omni.physx.bindings",
        "omni.physx",
    ),
    Moved(
        "omni.physxcommands",
        "omni.kit.commands.execute with the names of the commands, such as 'SetStaticCollider'",
    ),
    Moved(
        "omni.physx.commands",
        "omni.kit.commands.execute with the names of the commands, such as 'SetStaticCollider'",
    ),
    Moved(
        "omni.renderer_capture",
        "omni.kit.viewport.utility.capture_viewport_to_file, or BasicWriter",
    ),
    Moved(
        "omni.kit.renderer_capture",
        "omni.kit.viewport.utility.capture_viewport_to_file, or BasicWriter",
    ),
    Moved(
        "omni.hydratexture",
        "omni.replicator.core.create.render_product",
    ),
    Moved(
        "omni.stageupdate",
        "omni.kit.app.get_app().get_update_event_stream(), or omni.usd.get_context().get_stage_event_stream()",
    ),
    Moved(
        "omni.syntheticdata.generic_helper_lib",
        "omni.syntheticdata.helpers",
    ),
    Moved(
        "omni.replicator.core.utils.viewport_manager.ViewportManager",
        "omni.replicator.core.create.render_product; isaacsim.core.rendering_manager has a ViewportManager, too",
    ),
    Moved(
        "omni.replicator.core.scripts.utils.viewport_manager.ViewportManager",
        "omni.replicator.core.create.render_product; isaacsim.core.rendering_manager has a ViewportManager, too",
    ),
    Moved(
        "carb.get_framework",
        "functions that return an interface, such as carb.settings.get_settings(); there are no plugins",
    ),
    Moved(
        "carb.log_warning",
        "carb.log_warn",
    ),
    *(
        Moved(f"pxr.PhysxSchema.{name}", f"such joints are simulated: stage.DefinePrim(path, '{name}')")
        for name in ("PhysxPhysicsGearJoint", "PhysxPhysicsRackAndPinionJoint")
    ),
    Moved(
        "omni.syntheticdata.helpers.reduce_occlusion",
        "omni.replicator.core.annotators.get('occlusion'), whose rows are those of labeled prims already",
    ),
    Moved(
        "omni.client.set_alias",
        "`usdsdg run --map PREFIX=FOLDER`",
    ),
    Moved(
        "omni.client.mount",
        "`usdsdg run --map PREFIX=FOLDER`",
    ),
    *(
        Moved(
            f"{package}.utils.{library}",
            f"{library} itself, and isaacsim.core.utils.numpy.rotations for rotations of NumPy arrays",
        )
        for package in ("isaacsim.core", "omni.isaac.core")
        for library in ("torch", "warp")
    ),
)


def out_of_scope(module: str) -> OutOfScope | None:
    """Return the subject that a module belongs to; None where no row names it or a module above it."""
    found = [(prefix, row) for row in OUT_OF_SCOPE for prefix in row.prefixes if _is_below(module, prefix)]
    return max(found, key=lambda each: len(each[0]))[1] if found else None


def holds_out_of_scope(module: str) -> bool:
    """Return whether modules that are out of scope are below this one, which is nothing itself: `omni.kit.viewport`."""
    return any(prefix.startswith(f"{module}.") for row in OUT_OF_SCOPE for prefix in row.prefixes)


def moved(module: str) -> Moved | None:
    """Return where a module is now; None for one that no row names."""
    return next((row for row in MOVED if _is_below(module, row.prefix)), None)


def _is_below(module: str, prefix: str) -> bool:
    return module == prefix or module.startswith(f"{prefix}.")
