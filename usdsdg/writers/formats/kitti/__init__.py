"""The KITTI form: one text file of objects a picture, and its classes."""
