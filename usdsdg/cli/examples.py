"""An example of each command, for the end of its help."""

# Command -> (arguments, what they do).
EXAMPLES = {
    "run": [
        ("run script.py", "run a script unchanged"),
        ("run --stage scene.usd --frames 9 script.py --size 640", "with a stage open, and frames 0 to 9 started"),
    ],
    "generate": [
        ("generate configs/detection.yaml --set meshes=parts --set num_frames=100", "a dataset of your meshes"),
        ("generate configs/object_based.yaml --workers 4 --inspect", "by four processes, with a page at the end"),
    ],
    "render": [("render scene.usd pictures --camera /World/Camera", "one picture with depth, normals and masks")],
    "simulate": [("simulate scene.usd settled.usd --seconds 3", "let bodies fall for three seconds")],
    "view": [("view scene.usd", "a page on which the camera moves around the scene")],
    "inspect": [("inspect _out_detection", "a page of the dataset, _out_detection/inspect.html")],
    "verify": [("verify _out_detection", "check every file of the dataset")],
    "repair": [
        ("repair _out_detection", "make its damaged files again, and no others"),
        ("repair _out_detection --dry-run", "what is damaged, and which frames would be made"),
    ],
    "reproduce": [("reproduce _out_detection --frames 3:5", "make frames 3 and 4 again, and compare")],
    "merge": [("merge _out_detection", "join what --shard 0/4 to 3/4 have made")],
    "convert": [("convert mug.obj mug.usd --unit mm", "a mesh in millimeters to a USD file in meters")],
    "compat": [("compat script.py", "which names of the script are here")],
    "new": [("new detection", "write detection.yaml, which runs as it is")],
    "schema": [("schema > usdsdg.schema.json", "for editors, named in the first line of a configuration")],
    "warmup": [("warmup --device cpu", "compile all kernels ahead, as in a Dockerfile")],
    "doctor": [("doctor", "what is installed, and what would make this machine faster")],
    "completion": [("completion bash > ~/.usdsdg_completion.bash", "for `source` in ~/.bashrc")],
    "assets get": [
        ("assets get /Isaac/Props/YCB/Axis_Aligned/008_pudding_box.usd --assets-root https://example.com/assets",
         "copy an asset with all that it needs"),
    ],
    "assets list": [("assets list", "the files that have been copied")],
    "assets check": [("assets check", "whether copies are whole")],
}  # fmt: skip


def epilog(command: str) -> str:
    """Return the examples of a command as the last lines of its help."""
    examples = EXAMPLES[command]
    lines = [line for arguments, what in examples for line in (f"  usdsdg {arguments}", f"    ({what})")]
    return "\n".join([f"{'Examples' if len(examples) > 1 else 'Example'}:", *lines])
