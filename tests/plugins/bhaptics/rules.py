"""What the schema of this format can't say, as the facts about it have it."""


def check_tact(document, duration):
    assert document["intervalMillis"] == 20
    layouts = document["project"]["layout"]["layouts"]
    (track,) = document["project"]["tracks"]
    (effect,) = track["effects"]
    assert effect["modes"].keys() == layouts.keys()
    for position, mode in effect["modes"].items():
        indices = {motor["index"] for motor in layouts[position]}
        end = 0
        for feedback in mode["dotMode"]["feedback"]:
            assert (
                end
                <= feedback["startTime"]
                < feedback["endTime"]
                <= effect["offsetTime"]
                <= 1000 * duration + 20
            )
            end = feedback["endTime"]
            assert {point["index"] for point in feedback["pointList"]} <= indices


RULES = {
    ".tact": ("tact", lambda document, path, tracks: check_tact(document, tracks.duration)),
}
"""Schema and check of a file, by its ending."""
