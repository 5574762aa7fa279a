"""Properties of the sound from which a source's vibration is converted."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import bpy
from bpy.types import Context, Object, PropertyGroup

from ...core.devices import profile_files
from ..blender.extension import profile_folders
from ..blender.paths import local_path
from ..blender.words import TranslatedError
from .callbacks import changed, updating
from .kinds import choice, file_path, limited, reference, switch, text

if TYPE_CHECKING:
    from ...core.devices.profiles import Profile

ORIGINS = (
    ("FILE", "File", "A WAV, FLAC, MP3 or Ogg file"),
    (
        "SPEAKER",
        "Speaker",
        "The sound of a speaker, from the strips of its animation on, with its volume and pitch",
    ),
    ("SEQUENCER", "Sequencer", "Sound strips of the scene, at their times and with their volume"),
)
SOUNDS = (".wav", ".flac", ".mp3", ".ogg")
CARRIERS = (
    ("FIXED", "Fixed", "One frequency"),
    ("PITCH", "Pitch", "The sound's own pitch, moved by octaves into the band that is felt well"),
    ("DEVICE", "Device", "The frequency at which a device is felt most"),
)
SHOWN = {"PITCH": ("frequency",), "FIXED": ("frequency",), "DEVICE": ("device",)}
"""Properties of each carrier."""


def sound_path(owner: bpy.types.ID, path: str) -> Path:
    """A path that is stored with ``owner``, as an absolute path. Raises ValueError if there is no
    such file."""
    full = local_path(path, owner)
    if not full.is_file():
        raise TranslatedError("there is no file {}", full)
    return full


def device_profiles() -> Mapping[str, Profile]:
    """The built-in and the user's device profiles, by name."""
    return profile_files.load_profiles(profile_folders())[0]


def _matching_devices(self: PropertyGroup, context: Context, typed: str) -> list[str]:
    """What the search field of devices offers; Blender chooses those that match what was
    ``typed``."""
    return sorted(device_profiles())


def _edited(self: HapticSoundProperties, context: Context) -> None:
    self.is_edited, self.fault = True, ""
    try:
        if self.origin == "FILE" and self.filepath:
            sound_path(self.id_data, self.filepath)
    except ValueError as error:
        self.fault = str(error)  # other faults are found during the conversion


@updating(_edited, animated=False)
class HapticSoundProperties(PropertyGroup):
    """A sound, the settings of its conversion, and the resulting vibration."""

    reasons = {
        "*": "the file that is felt, and the device that plays it",
    }

    origin: choice("Sound", "Where the sound comes from", ORIGINS)
    filepath: file_path("File", "The sound that becomes vibration")
    speaker: reference(
        Object,
        "Speaker",
        "It plays the sound",
        poll=lambda self, obj: obj.type == "SPEAKER",
        update=_edited,
    )
    strip: text("Strip", "One sound strip; empty for all that are not muted")
    loop: switch("Loop", "Play it again and again; otherwise once, at the scene's beginning")
    carrier: choice("Carrier", "The vibration whose amplitude follows the sound", CARRIERS)
    frequency: limited(
        "Frequency (Hz)",
        "Frequency of the carrier in hertz; where it follows the pitch, the frequency of sounds "
        "without one",
        160.0,
        (10.0, 1000.0),
    )
    device: text("Device", "The profile of the device", "dualsense", search=_matching_devices)
    gain: limited(
        "Gain",
        "Makes the vibration of the sound stronger or weaker",
        1.0,
        (0.0, 100.0),
        soft_max=10.0,
    )
    kept: text("Vibration", "What was made of the sound", options={"HIDDEN"}, update=changed)
    waves: text("Waves", "The sound and its vibration as the panel draws them", options={"HIDDEN"})
    taken: text(
        "Taken", "What the vibration was made of, beside these settings", options={"HIDDEN"}
    )
    is_edited: switch(
        "Edited", "These settings have changed since the conversion", options={"HIDDEN"}
    )
    fault: text("Fault", "What is wrong with the sound", options={"HIDDEN"})
