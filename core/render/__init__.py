"""From gains to samples: voices, mixing and playback of what each listener feels."""
