"""The haptic graph as geometry that Cycles and EEVEE render."""
