"""What changed, which views have to be drawn again, and when handlers must do nothing."""
