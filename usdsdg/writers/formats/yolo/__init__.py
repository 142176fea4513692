"""The YOLO form: one text file of normalized shapes a picture."""
