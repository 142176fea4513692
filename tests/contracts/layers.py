"""The table of layers: every package, room and root module with what of the project it may import.

The order is from the bottom to the top: a row names only rows above it, so there are no cycles. A room of an engine may
import what `OF_ENGINES` names besides the rooms of its own engine that its row names.
"""

ENGINES = ("usdsdg_physics", "usdsdg_render")
# What their rooms may import of usdsdg.
OF_ENGINES = (
    *("errors", "image_files", "kernels", "listeners", "operating_system", "parallel", "readback", "stage"),
    "warp_start",
)

# usdsdg: name -> what it may import, names without "usdsdg.".
USDSDG = {
    "errors": "",
    "listeners": "errors",
    "snapshots": "",
    "operating_system": "",
    "parallel": "operating_system",
    "buffers": "",
    "readback": "buffers",
    "kernels": "errors",
    "warp_start": "errors kernels parallel",
    "stores": "errors operating_system",
    "image_files": "errors warp_start",
    "stage": "errors operating_system image_files",
    "session": "errors listeners operating_system stage warp_start",
    "articulations": "errors stage session",
    "graph": "errors stage session",
    "arguments": "errors stage session graph",
    "settings": "errors stage session arguments graph",
    "rng": "session arguments graph",
    "distribution": "errors arguments graph",
    "scatter": "errors stage arguments",
    "calibration": "errors stage arguments",
    # what scripts call
    "modify": "errors stage session arguments graph distribution scatter",
    "create": "errors stage session arguments graph distribution modify calibration",
    "randomizer": "errors stage session arguments graph distribution scatter modify",
    "annotators": "errors snapshots warp_start parallel buffers readback stage session arguments graph",
    "writers": "errors snapshots operating_system warp_start image_files stores stage session arguments annotators",
    "functional": "errors stage session arguments graph rng scatter randomizer writers",
    "physics": "errors stage arguments graph distribution modify functional",
    "get": "errors stage session arguments graph functional",
    "trigger": "errors session arguments graph functional",
    "utils": "errors stage session arguments graph modify",
    "annotators_default": "annotators",
    "augmentations_default": "annotators",
    "backends": "session arguments writers",
    "tools": "errors arguments annotators writers",
    "writers_default": "writers tools",
    # what runs it
    "record": "stage",
    "capture": "errors operating_system parallel readback stores stage session graph distribution create annotators "
    "writers record usdsdg_render.settings",
    "app": "errors listeners stage session graph rng distribution create annotators writers trigger capture",
    "orchestrator": "errors session arguments app",
    "demo": "errors image_files stage",
    "mirror": "errors operating_system stores stage session",
    "meshes": "errors image_files stores stage session mirror",
    "example": "demo",
    "datasets": "errors stage stores writers record",
    "pictures": "annotators writers",
    "inspect": "errors stage writers datasets pictures",
    "notebook": "errors stage session arguments graph create annotators writers capture pictures datasets inspect",
    "verify": "errors parallel stores stage session annotators writers record datasets",
    "repair": "errors stores session writers record datasets verify",
    "replicator_yaml": "errors session arguments graph orchestrator __init__",
    "scenarios": "errors image_files stores stage session arguments graph calibration create writers capture app "
    "orchestrator settings demo meshes __init__",
    "compat": "errors listeners operating_system warp_start image_files stores stage session articulations arguments "
    "graph distribution create annotators writers functional app orchestrator settings demo",
    "cli": "errors operating_system warp_start stage session",
    "workers": "errors operating_system stage stores session writers",
    "stream": (
        "errors operating_system stores session annotators writers capture scenarios replicator_yaml cli __init__"
    ),
    "torch": "errors session stream",
    "view": "errors stage session graph annotators writers capture app orchestrator pictures inspect cli stream",
    "__main__": "cli",
    "__init__": "",
}

PHYSICS = {
    "body_points": "",
    "scene": "",
    "parse": "scene",
    "solver": "",
    "contact_solver": "body_points solver",
    "model": "scene parse solver contact_solver",
    "corrections": "body_points scene",
    "guards": "body_points scene corrections",
    "queries": "scene",
    "world": "scene solver model corrections guards",
    "edits": "scene parse queries world",
    "writeback": "scene",
    "play": "scene parse queries world edits writeback",
    "settling": "world play",
    "simulated_bodies": "scene play",
    "simulated_joints": "play",
    "stage_joints": "play simulated_joints",
    "engine": "scene parse queries world play settling simulated_bodies stage_joints",
    "simulation": "world engine",
    "__init__": "",
}

RENDER = {
    "settings": "",
    "scene": "",
    "usd": "scene",
    "images": "scene usd",
    "geometry": "scene usd images",
    "materials": "scene usd images geometry",
    "memory": "",
    "bvh": "scene memory",
    "kernels": "scene geometry bvh",
    "lights": "scene usd images materials kernels",
    "sync": "scene usd images geometry materials lights",
    "device": "scene geometry memory bvh kernels lights",
    "labels": "scene memory kernels device",
    "path": "settings scene memory kernels device",
    "worlds": "settings scene usd sync kernels device labels path",
    "renderer": "settings scene sync memory kernels device labels path worlds",
    "__init__": "",
}

# Module -> (what it imports inside functions, why not at its top). Nothing else may be imported there.
COMMAND = "help and errors of the command line appear before anything heavy is loaded"
SHOWN = "what a notebook shows of an object is drawn by what stands above it, when it is shown"
LATE = {
    "usdsdg": (
        "usdsdg.stage usdsdg.notebook usdsdg.arguments usdsdg.errors",
        "schemas are registered at once only where pxr is loaded already, stages are shown only where IPython runs, "
        "and names are looked for elsewhere, and errors loaded for it, only where there is none",
    ),
    "usdsdg.annotators.annotator": ("usdsdg.notebook", SHOWN),
    "usdsdg.session.render_products": ("usdsdg.notebook", SHOWN),
    "usdsdg.graph.node": ("usdsdg.notebook", SHOWN),
    "usdsdg.graph.evaluate": ("usdsdg.notebook", SHOWN),
    "usdsdg.session.devices.choice": ("usdsdg_render.renderer", "warp takes a second to import"),
    "usdsdg.session.engines": (
        "usdsdg_physics.engine usdsdg_render.renderer usdsdg_render.labels usdsdg_render.device",
        "newton takes seconds to import, warp one",
    ),
    "usdsdg.capture.render_settings": ("usdsdg_render.path", "warp takes a second to import"),
    "usdsdg.capture.worlds": ("usdsdg_render.labels", "warp takes a second to import"),
    "usdsdg.capture.tiles": ("usdsdg_render.labels", "warp takes a second to import"),
    "usdsdg.session.session": (
        "usdsdg.session usdsdg.articulations usdsdg.graph usdsdg.rng usdsdg.writers usdsdg.capture usdsdg.app "
        "usdsdg.compat usdsdg.demo usdsdg.mirror usdsdg.annotators usdsdg.meshes",
        "the one object that owns the state of all packages names their parts, and makes each when it is first used",
    ),
    "usdsdg_physics.model.build": ("usdsdg_physics.contact_solver", "its kernels are defined where a scene needs them"),
    "usdsdg_physics.world.step_corrections": (
        "usdsdg_physics.corrections",
        "its kernels are defined when a scene needs them",
    ),
    "usdsdg_physics.world.compile_kernels": (
        "usdsdg_physics.corrections usdsdg_physics.guards usdsdg_physics.queries usdsdg_physics.solver",
        "defining kernels and compiling them is the work that this module does on two threads",
    ),
    "usdsdg.cli.commands.assets": ("usdsdg.mirror", COMMAND),
    "usdsdg.cli.app": ("usdsdg.__init__", COMMAND),
    "usdsdg.cli.commands.compat": ("usdsdg.compat", COMMAND),
    "usdsdg.cli.commands.convert": ("usdsdg.meshes", COMMAND),
    "usdsdg.cli.commands.doctor": (
        "usdsdg.__init__ usdsdg_render.path usdsdg_render.device usdsdg_render.renderer",
        COMMAND,
    ),
    "usdsdg.cli.options.file_kinds": ("usdsdg.arguments usdsdg.scenarios", COMMAND),
    "usdsdg.cli.commands.generate": ("usdsdg.parallel usdsdg.scenarios usdsdg.workers", COMMAND),
    "usdsdg.cli.commands.inspect": ("usdsdg.datasets usdsdg.inspect", COMMAND),
    "usdsdg.cli.commands.new": ("usdsdg.stores", COMMAND),
    "usdsdg.cli.commands.render": ("usdsdg.stores usdsdg.__init__", COMMAND),
    "usdsdg.cli.commands.run": ("usdsdg.replicator_yaml usdsdg.writers", COMMAND),
    "usdsdg.cli.options.rerun_option": ("usdsdg.writers", COMMAND),
    "usdsdg.cli.script.missing_names": ("usdsdg.compat", COMMAND),
    "usdsdg.cli.script.workers": ("usdsdg.parallel usdsdg.workers", COMMAND),
    "usdsdg.cli.script.execution": ("usdsdg.app usdsdg.compat usdsdg.orchestrator usdsdg.writers", COMMAND),
    "usdsdg.cli.options.command_context": ("usdsdg.graph usdsdg.orchestrator usdsdg.settings usdsdg.writers", COMMAND),
    "usdsdg.cli.options.dataset_options": ("usdsdg.writers", COMMAND),
    "usdsdg.cli.datasets_in": ("usdsdg.stores usdsdg.writers", COMMAND),
    "usdsdg.cli.commands.merge": ("usdsdg.datasets usdsdg.stores usdsdg.writers", COMMAND),
    "usdsdg.cli.commands.schema": ("usdsdg.scenarios", COMMAND),
    "usdsdg.cli.made_again": ("usdsdg.datasets usdsdg.graph usdsdg.scenarios usdsdg.stores usdsdg.writers", COMMAND),
    "usdsdg.cli.commands.repair": ("usdsdg.repair usdsdg.stores usdsdg.verify usdsdg.writers", COMMAND),
    "usdsdg.cli.commands.reproduce": ("usdsdg.datasets usdsdg.verify usdsdg.writers", COMMAND),
    "usdsdg.cli.options.thread_limit": ("usdsdg.parallel usdsdg.writers", COMMAND),
    "usdsdg.cli.commands.verify": ("usdsdg.datasets usdsdg.verify", COMMAND),
    "usdsdg.cli.commands.warmup": (
        "usdsdg.kernels.compilation usdsdg.parallel usdsdg_physics.__init__ usdsdg_render.device "
        "usdsdg_render.renderer",
        COMMAND,
    ),
    "usdsdg.cli.commands.simulate": ("usdsdg_physics.__init__", COMMAND),
    "usdsdg.cli.commands.view": ("usdsdg.view", COMMAND),
}

# Packages that need what is not installed with usdsdg, by the name of what they need.
NEEDS = {("usdsdg", "torch"): "torch"}
