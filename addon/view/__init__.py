"""What is drawn: the haptic graph, meters and pictures in panels."""
