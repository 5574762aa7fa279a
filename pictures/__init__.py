"""Pictures of scenes with their haptic graph, drawn without a window: for the command line, the
study and the documentation."""
