"""What formats of keyframes share: bands, and impacts as transients."""
