"""Timeline of Touch: what listeners feel over time, over Timeline and Dope Sheet."""
