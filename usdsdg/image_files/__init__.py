"""Image and video codecs: PNG, OpenEXR, Radiance HDR, motion JPEG."""
