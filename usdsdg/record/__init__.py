"""What is kept beside a dataset, in the hidden folder `.usdsdg` of a writer's output: a record of every frame."""

FOLDER = ".usdsdg"
FRAMES = f"{FOLDER}/frames"
CLASSES = f"{FOLDER}/classes.json"
STAGES = f"{FOLDER}/stages"
