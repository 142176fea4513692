"""The Pascal VOC form: an XML file and two pictures of segments for each picture, and lists of pictures."""
