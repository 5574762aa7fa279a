"""The tracks of the study."""

from study_tracks import study  # noqa: F401
