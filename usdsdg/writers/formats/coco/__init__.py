"""The COCO form: images, categories, boxes, and masks as run lengths."""
