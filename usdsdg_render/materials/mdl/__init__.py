"""MDL materials of Omniverse: their files, and the templates that these call."""
