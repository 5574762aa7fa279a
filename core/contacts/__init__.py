"""Contact detection: from shapes and poses of haptic objects to contact patches, their begin and
end, and impacts."""
