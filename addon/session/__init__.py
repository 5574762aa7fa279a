"""The live tracing of each scene."""
