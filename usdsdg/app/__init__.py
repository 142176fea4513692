"""The application: app updates, the event loop of scripts, and the frame loop."""
