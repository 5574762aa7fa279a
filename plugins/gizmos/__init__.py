"""Gizmos in the viewport: handles of amplitudes and radii, and words at what is under the mouse."""
