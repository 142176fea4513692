"""The form of DOPE's training data, as Isaac Sim's DOPEWriter has it."""
