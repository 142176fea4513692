"""`isaacsim.replicator.behavior.behaviors`: one behavior per file."""

from usdsdg.compat.isaacsim.replicator.behavior.behaviors.example_base_behavior import ExampleBaseBehavior
from usdsdg.compat.isaacsim.replicator.behavior.behaviors.example_behavior import ExampleBehavior
from usdsdg.compat.isaacsim.replicator.behavior.behaviors.light_randomizer import LightRandomizer
from usdsdg.compat.isaacsim.replicator.behavior.behaviors.location_randomizer import LocationRandomizer
from usdsdg.compat.isaacsim.replicator.behavior.behaviors.look_at_behavior import LookAtBehavior
from usdsdg.compat.isaacsim.replicator.behavior.behaviors.rotation_randomizer import RotationRandomizer
from usdsdg.compat.isaacsim.replicator.behavior.behaviors.texture_randomizer import TextureRandomizer
from usdsdg.compat.isaacsim.replicator.behavior.behaviors.volume_stack_randomizer import VolumeStackRandomizer

__all__ = [
    "ExampleBaseBehavior", "ExampleBehavior", "LightRandomizer", "LocationRandomizer", "LookAtBehavior",
    "RotationRandomizer", "TextureRandomizer", "VolumeStackRandomizer",
]  # fmt: skip
