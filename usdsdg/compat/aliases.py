"""Foreign modules that are at another place than their names say: `omni.isaac.core` is `isaacsim.core.api`."""

_OLD_PRIM_MODULES = (
    "xform_prim", "xform_prim_view", "rigid_prim", "rigid_prim_view", "geometry_prim", "geometry_prim_view",
    "rigid_contact_view",
)  # fmt: skip
_WRITERS = "usdsdg.compat.isaacsim.replicator.writers"
_WRITER_PACKAGES = tuple(
    f"{extension}.scripts{part}"
    for extension in ("isaacsim.replicator.writers", "omni.replicator.isaac")
    for part in (".writers", "")
)
_WRITER_MODULES = (
    "data_visualization_writer", "dope_writer", "pose_writer", "pytorch_listener", "pytorch_writer", "ycb_video_writer",
)  # fmt: skip
# Longest prefix first: a name, with all below it, and the module of usdsdg that it is.
ALIASES = (
    ("omni.replicator.core.scripts.functional.io_functions", "usdsdg.writers.files"),
    ("omni.replicator.core.functional.io_functions", "usdsdg.writers.files"),
    ("omni.replicator.core.scripts.utils.rng", "usdsdg.rng"),
    ("omni.replicator.core.utils.rng", "usdsdg.rng"),
    ("omni.replicator.core.bindings._omni_replicator_core", "usdsdg.compat.omni.replicator.telemetry"),
    ("omni.replicator.core.bindings", "usdsdg.compat.omni.replicator"),
    *(
        (f"omni.replicator.core{part}", f"usdsdg.compat.omni.replicator.{name}")
        for name, parts in (
            ("io_queue", (".scripts.backends.io_queue", ".backends.io_queue")),
            ("annotator_utils", (".scripts.utils.annotator_utils", ".utils.annotator_utils")),
        )
        for part in parts
    ),
    # The modules of the backends are one.
    *(
        (f"omni.replicator.core{part}.backends.{name}", "usdsdg.backends")
        for part in (".scripts", "")
        for name in ("base", "disk", "dispatcher", "group", "registry", "s3", "sequential")
    ),
    # As the modules of the registries were named at first.
    ("omni.replicator.core.scripts.annotator_registry", "usdsdg.annotators"),
    ("omni.replicator.core.scripts.writer_registry", "usdsdg.writers"),
    ("omni.replicator.core.scripts", "usdsdg"),
    ("omni.replicator.core", "usdsdg"),
    ("omni.replicator.replicator_yaml", "usdsdg.replicator_yaml"),
    *(
        (f"{extension}.scripts.utils", "usdsdg.compat.isaacsim.replicator.writer_utils")
        for extension in ("isaacsim.replicator.writers", "omni.replicator.isaac")
    ),
    # The modules of the writers, one per class, and their packages are one module.
    *((f"{package}.{name}", _WRITERS) for package in _WRITER_PACKAGES for name in _WRITER_MODULES),
    *((package, _WRITERS) for package in _WRITER_PACKAGES),
    ("omni.replicator.isaac", "usdsdg.compat.isaacsim.replicator.domain_randomization"),
    (
        "isaacsim.replicator.domain_randomization.scripts",
        "usdsdg.compat.isaacsim.replicator.domain_randomization",
    ),
    ("omni.usd.commands", "usdsdg.compat.omni.kit.commands.command_classes"),
    ("omni.usd._impl.utils", "usdsdg.compat.omni.usd"),
    ("omni.usd.utils", "usdsdg.compat.omni.usd"),
    ("omni.usd._impl", "usdsdg.compat.omni.usd"),
    ("omni.kit.scripting", "usdsdg.compat.omni.behavior.scripting.core"),
    ("omni.isaac.sensor._sensor", "usdsdg.compat.isaacsim.sensors.physics._sensor"),
    ("omni.isaac.sensor.scripts.camera", "usdsdg.compat.isaacsim.sensors.camera"),
    *(
        (f"omni.isaac.sensor.scripts.{name}", "usdsdg.compat.omni.isaac.sensor")
        for name in ("camera_view", "contact_sensor", "imu_sensor", "effort_sensor")
    ),
    ("omni.isaac.sensor.scripts", "usdsdg.compat.omni.isaac.sensor"),
    ("omni.isaac.sensor", "usdsdg.compat.omni.isaac.sensor"),
    ("omni.syntheticdata.scripts.SyntheticData", "usdsdg.compat.omni.syntheticdata.synthetic_data"),
    ("omni.syntheticdata.scripts", "usdsdg.compat.omni.syntheticdata"),
    # Isaac Sim 4's names of the core. Modules below these packages, one per class, are the packages themselves.
    *((f"omni.isaac.core.prims.{name}", "usdsdg.compat.omni.isaac.core.prims") for name in _OLD_PRIM_MODULES),
    ("omni.isaac.core.prims", "usdsdg.compat.omni.isaac.core.prims"),
    *(
        (f"omni.isaac.core.articulations.{name}", "usdsdg.compat.omni.isaac.core.articulations")
        for name in ("articulation", "articulation_view", "articulation_subset", "articulation_gripper")
    ),
    ("omni.isaac.core.articulations", "usdsdg.compat.omni.isaac.core.articulations"),
    ("omni.isaac.core.utils", "usdsdg.compat.isaacsim.core.utils"),
    *(
        (f"{package}.{name}.{name}", f"usdsdg.compat.isaacsim.core.api.{name}")
        for package in ("omni.isaac.core", "isaacsim.core.api")
        for name in ("simulation_context", "world", "physics_context")
    ),
    ("omni.isaac.core", "usdsdg.compat.isaacsim.core.api"),
    ("omni.isaac.cloner", "usdsdg.compat.isaacsim.core.cloner"),
    *(
        (f"isaacsim.storage.native.{name}", "usdsdg.compat.isaacsim.storage.native")
        for name in ("nucleus", "impl.file_utils", "impl.nucleus", "impl")
    ),
    ("Semantics", "usdsdg.stage.schemas.semantics_schema"),
    ("omni.isaac.version", "usdsdg.compat.isaacsim.core.version"),
    ("isaacsim.core.simulation_manager.impl", "usdsdg.compat.isaacsim.core.simulation_manager"),
    ("isaacsim.core.prims.impl", "usdsdg.compat.isaacsim.core.prims"),
    ("isaacsim.core.utils.impl", "usdsdg.compat.isaacsim.core.utils"),
    *(
        (f"isaacsim.core.experimental.{part}.impl", f"usdsdg.compat.isaacsim.core.experimental.{part}")
        for part in ("materials", "objects", "prims", "utils")
    ),
    ("isaacsim.simulation_app.utils", "usdsdg.compat.omni.isaac.kit.utils"),
    ("omni.isaac.nucleus.nucleus", "usdsdg.compat.omni.isaac.nucleus"),
    *(
        (f"{package}.app_framework", "usdsdg.compat.isaacsim.app_framework")
        for package in ("omni.isaac.kit", "isaacsim.simulation_app")
    ),
    ("omni.isaac.kit.simulation_app", "usdsdg.compat.isaacsim.simulation_app"),
    ("isaacsim.simulation_app.simulation_app", "usdsdg.compat.isaacsim.simulation_app"),
    ("omni.isaac.benchmark", "usdsdg.compat.isaacsim.benchmark"),
)
