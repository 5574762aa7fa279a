"""Nintendo's Switch Pro Controller and Joy-Con."""

DEVICES = (f"{__name__}.switch",)
