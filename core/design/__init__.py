"""Materials from wishes and from recordings: the values that make a scene pass on what is wanted, or what was measured."""
