"""What reading the labeled prims of a stage takes: numbers, mappings of ids, possible labels, keypoints, subsets."""
