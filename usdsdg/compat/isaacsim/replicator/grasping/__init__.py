"""`isaacsim.replicator.grasping`: sample poses of grippers around an object, and close the gripper at each."""
