"""The form of a small study with people: one item, nothing excluded but what is incomplete or all
alike."""

FORM = """
title = "T"
smallest_effect = 0.5
consent = "C"
instructions = "I"
about = {}
words = []
scale = {low = 1, high = 5}
items = [{factor = "Realism", text = "R"}]
exclusion = {incomplete = true, same_answers = true, seconds_per_item = 0}
"""
"""To be followed by ``conditions`` and ``scenes``."""
