"""The files of results of a `GraspingManager`."""

from __future__ import annotations

import os
from pathlib import Path

from pxr import Gf

from usdsdg.compat.isaacsim.replicator.grasping import config_file, grasping_utils


class GraspResults:
    """Writes a file for each grasp that was evaluated, into a folder if there is one."""

    _results_folder: Path | None = None
    _overwrite = False
    _results = 0
    _object_path: str | None
    gripper_path: str

    def set_results_output_dir(self, dir_path: str | None) -> None:
        """Set the folder of results; empty or None writes none."""
        given = dir_path.strip() if isinstance(dir_path, str) else ""
        self._results_folder = Path(os.path.expanduser(given)) if given else None

    def get_results_output_dir(self) -> str | None:
        return str(self._results_folder) if self._results_folder else None

    def set_overwrite_results_output(self, overwrite: bool) -> None:
        """Set whether results replace existing files, or take the next free number."""
        self._overwrite = overwrite

    def write_grasp_results(self, location: Gf.Vec3d, orientation: Gf.Quatd) -> None:
        """Write capture_<n>.yaml: the paths, the gripper's pose, and the positions of its joints.

        Raises:
            OSError: the file cannot be written.
        """
        if self._results_folder is None:
            return
        states = grasping_utils.get_gripper_joint_states(self.gripper_path)
        if states is None:
            return
        result = {
            "gripper_path": self.gripper_path,
            "object_path": self._object_path,
            "gripper_location": list(location),
            "gripper_orientation": config_file.quat_to_mapping(orientation),
            "joint_states": states,
        }
        while not self._overwrite and self._result_file().exists():
            self._results += 1
        grasping_utils.write_yaml_config(str(self._result_file()), {"grasp_result": result}, overwrite=True)
        self._results += 1

    def _result_file(self) -> Path:
        assert self._results_folder is not None
        return self._results_folder / f"capture_{self._results}.yaml"
