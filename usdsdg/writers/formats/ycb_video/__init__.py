"""The form of the YCB-Video dataset, as Isaac Sim's YCBVideoWriter has it."""
