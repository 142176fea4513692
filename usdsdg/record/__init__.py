"""What is kept beside a dataset, in the hidden folder `.usdsdg` of a writer's output: a record of every frame."""

from usdsdg.stage.semantics.semantic_classes import BESIDE, FILE

FRAMES = f"{BESIDE}/frames"
STAGES = f"{BESIDE}/stages"
CLASSES = f"{BESIDE}/{FILE}"
