"""Device families: how each kind of device is recognised, commanded, stopped and released."""
