"""The form that the annotation tool CVAT imports: "CVAT for images 1.1"."""
