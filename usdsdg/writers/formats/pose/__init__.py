"""The pose forms of Isaac Sim: JSON for CenterPose and DOPE, and the overlay."""
