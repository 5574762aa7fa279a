"""Changes of the file, requests to redraw, and suspension of handlers."""
