"""Calibrated cameras and rigs as users have them: files of OpenCV, ROS and Kalibr, and lists of cameras."""
