"""Contacts between haptic objects: shapes and poses in, touching pairs with their patch, begin, end and impact energy out."""
