"""What reading the labeled prims of a stage takes: their numbers, possible labels, keypoints, and subsets."""
