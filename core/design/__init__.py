"""Material values that fulfil desired levels, or that are fitted to recordings."""
