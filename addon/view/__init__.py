"""Drawing: the haptic graph over the viewport, in pictures and as geometry; meters; pictures in
panels."""
