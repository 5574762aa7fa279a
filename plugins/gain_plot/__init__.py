"""Plot of the gain over distance of the active object."""
