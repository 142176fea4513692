"""The application: updates, the event loop of scripts, and the order of one captured frame."""
