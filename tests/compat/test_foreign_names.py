"""Names that are known and not here: they import, and say what they are or where their work is done."""

import textwrap
from typing import Any, cast

import pytest

from tests import forked
from usdsdg.compat import finder, foreign_names
from usdsdg.compat.placeholders import PlaceholderModule, placeholder
from usdsdg.errors import Unsupported


def run(code: str) -> str:
    """Run code after `compat.install()`; return what it prints. `told(...)` prints the error that code raises."""
    head = """
    import usdsdg.compat; usdsdg.compat.install()
    def told(code, **names):
        try:
            exec(code, names)
        except Exception as error:
            print(type(error).__name__, error)
        else:
            print("nothing")
    """
    program = textwrap.dedent(head) + textwrap.dedent(code)
    done = forked.run(["-c", program], cwd=forked.ROOT)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_scripts_import_what_is_out_of_scope_and_use_it_harmlessly():
    run(
        """
        import abc
        import carb.input, omni.ext, omni.kit.window.property
        import omni.ui as ui
        import isaacsim.robot.manipulators.grippers as grippers
        import isaacsim.sensors.rtx
        from isaacsim.ros2.bridge import ROS2Context
        from isaacsim.robot.manipulators import controllers
        from omni.physx.scripts import deformableUtils

        class Window(ui.Window, abc.ABC):
            label: ui.Label | None = None
            def build(self, where=ui.Alignment.CENTER) -> ui.Button: ...

        class Extension(omni.ext.IExt):
            def on_startup(self, ext_id): ...

        assert not isinstance(3, ui.Window) and issubclass(Window, ui.Window)
        assert controllers.PickPlaceController and carb.input.KeyboardInput.A
        """
    )


def test_what_is_out_of_scope_says_so_when_it_is_used():
    told = run(
        """
        import omni.ui as ui
        from isaacsim.ros2.bridge import ROS2Context
        told("ROS2Context()", ROS2Context=ROS2Context)
        told("ui.Window('title', width=3)", ui=ui)
        told("class W(ui.Window): ...\\nW()", ui=ui)
        told("with ui.VStack(): ...", ui=ui)
        told("ui.get_style.x", ui=ui)
        told("list(ui.Items)", ui=ui)
        from isaacsim.robot.manipulators.grippers import ParallelGripper
        told("ParallelGripper('/World/hand')", ParallelGripper=ParallelGripper)
        """
    ).splitlines()
    assert told[0].startswith(
        "Unsupported isaacsim.ros2.bridge.ROS2Context: ROS and other message buses are out of scope"
    )
    assert all("omni.ui." in each and "There is no window" in each for each in told[1:6])
    assert "controllers of particular robots" in told[6]
    assert len(told) == 7


def test_a_module_that_is_elsewhere_says_where():
    told = run(
        "told('from omni.isaac.synthetic_utils import DataWriter'); told('import omni.replicator.isaac.randomize')"
    )
    first, second = told.splitlines()
    assert "annotators.get(name)" in first
    assert "isaacsim.replicator.domain_randomization" in second


def test_a_script_imports_its_own_packages_with_names_of_omniverse(tmp_path):
    for file, text in {
        "isaacsim/ocean/sensors/sonar.py": "from isaacsim.core.utils.stage import get_current_stage\nrange_of = 7",
        "isaacsim/ocean/__init__.py": "from .sensors import sonar",
        "omni/acme/tools.py": "import omni.usd\nfrom omni.acme.other import size",
        "omni/acme/other.py": "size = 3",
        "omni/isaac/empty/notes.txt": "no module",
    }.items():
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).write_text(text)
    told = run(
        f"""
        import sys; sys.path.insert(0, {str(tmp_path)!r})
        import isaacsim.ocean, omni.acme.tools
        from isaacsim.ocean.sensors.sonar import range_of
        print(range_of, isaacsim.ocean.sonar.range_of, omni.acme.tools.size, omni.usd.get_context().get_stage_id() > 0)
        told("import omni.isaac.empty")
        told("import omni.acme.missing")
        told("from omni.acme.tools import size2")
        """
    ).splitlines()
    assert told[0] == "7 7 3 True"
    assert told[1].startswith("ModuleNotFoundError omni.isaac.empty: this module of Isaac Sim or Omniverse")
    assert told[2].startswith("ModuleNotFoundError omni.acme.missing")
    assert told[3].startswith("ImportError cannot import name 'size2' from 'omni.acme.tools'")


def test_a_module_that_nobody_knows_is_an_error_with_similar_names():
    told = run("told('import isaacsim.core.util.stage'); told('import omni.foo'); told('import isaacsim.xyz.y')")
    first, second, third = told.splitlines()
    assert "isaacsim.core.util: this module" in first
    assert "Did you mean isaacsim.core.utils" in first
    assert all(each.startswith("ModuleNotFoundError") and "no counterpart" in each for each in (first, second, third))


def test_a_name_that_a_shim_lacks_is_an_error_with_the_foreign_name_and_similar_ones():
    told = run(
        """
        import isaacsim.core.utils.stage as stage
        told("stage.open_stag", stage=stage)
        told("from isaacsim.core.utils.stage import open_stag")
        told("from omni.isaac.nucleus import get_asset_root_path")
        told("from omni.replicator.core import Wrter")
        print(hasattr(stage, "nothing"), getattr(stage, "nothing", 3))
        """
    ).splitlines()
    near = "isaacsim.core.utils.stage of usdsdg has no 'open_stag'; did you mean open_stage"
    assert told[0].startswith(f"AttributeError {near}")
    assert told[1].startswith(f"ModuleNotFoundError {near}")
    assert "get_assets_root_path" in told[2]
    assert "omni.replicator.core of usdsdg has no 'Wrter'; did you mean Writer" in told[3]
    assert told[4] == "False 3"


def test_rows_of_the_table_are_names_that_the_finder_resolves_and_are_there_once():
    prefixes = [prefix for row in foreign_names.OUT_OF_SCOPE for prefix in row.prefixes]
    assert len(prefixes) == len(set(prefixes))
    assert {each.split(".")[0] for each in prefixes} <= set(finder.ROOTS)


@pytest.mark.parametrize(
    ("module", "subject"),
    [
        ("omni.ui", "windows"), ("omni.ui.scene", "windows"), ("omni.uix", None), ("omni", None),
        ("isaacsim.ros2.bridge", "ROS"), ("isaacsim.replicator.behavior.ui", "windows"), ("isaacsim.core.utils", None),
        ("omni.isaac.sensor.LidarRtx", "lidar"), ("omni.isaac.sensor.RotatingLidarPhysX", "lidar"),
        ("omni.isaac.sensor.Camera", None), ("isaacsim.sensors.experimental.rtx.RtxCamera", "the"),
        ("isaacsim.sensors.experimental.rtx.LidarSensor", "lidar"),
    ],
)  # fmt: skip
def test_a_row_stands_for_a_module_and_all_below_it(module, subject):
    found = foreign_names.out_of_scope(module)
    assert (found.subject.split()[0].rstrip(",") if found else None) == subject


def test_a_name_with_a_row_of_its_own_is_refused_with_what_that_says():
    name = "isaacsim.sensors.experimental.rtx"
    subject = foreign_names.out_of_scope(name)
    assert subject is not None
    module: Any = PlaceholderModule(name, subject)
    with pytest.raises(Unsupported, match=r"RtxCamera: the cameras .* CameraView of isaacsim\.sensors\.camera"):
        module.RtxCamera("/World/camera")
    with pytest.raises(Unsupported, match=r"Lidar\.create: lidar"):
        module.Lidar.create("/World/lidar")


def test_a_placeholder_refuses_what_cannot_be_harmless():
    subject = foreign_names.OUT_OF_SCOPE[0]
    made: Any = placeholder("a.b.Thing", subject)
    for use in (made, lambda: list(made), lambda: len(made), lambda: int(made), lambda: float(made)):
        with pytest.raises(Unsupported, match=r"a\.b\.Thing: "):
            use()
    assert made.CONSTANT.VALUE.__name__ == "VALUE"
    assert bool(made)
    with pytest.raises(Unsupported, match=r"a\.b\.function"):
        cast("Any", PlaceholderModule("a.b", subject)).function()


@pytest.mark.parametrize(
    ("module", "name", "remedy"),
    [("utils", "AttrMap", "modify.attribute"), ("randomizer", "objects", "randomizer.instantiate")],
)
def test_a_name_whose_work_is_done_elsewhere_says_where(module, name, remedy):
    told = run(f"import omni.replicator.core.{module} as found; told('found.{name}', found=found)")
    assert told.startswith("AttributeError")
    assert remedy in told
