"""What has changed since the last trace, and when tracing is suspended."""
