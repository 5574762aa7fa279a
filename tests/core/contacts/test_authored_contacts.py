"""What an author says of contacts comes before what is found, and only where it was said."""

import numpy as np
from haptic_tracing.core.contacts.authored import AuthoredContacts
from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.contacts.settings import Body
from haptic_tracing.core.contacts.shapes import Box
from haptic_tracing.core.scene.functions import Constant, function_from_dict
from haptic_tracing.core.scene.values import Contact, HapticObject, Listener, Settings, Source
from haptic_tracing.core.tracer import Frame, Tracer

INDEX = {"a": 0, "b": 1, "c": 2}


def contact(first, second, x=0.0, **more):
    return Contact((first, second), ((x, 0, 0), (x, 0, 0)), **more)


def contacts(*items):
    return ContactSet.from_contacts(items, INDEX)


def test_between_settled_objects_only_the_authored_count():
    found = contacts(contact("a", "b", 1.0), contact("b", "c", 2.0))
    given = contact("a", "b", 5.0, area=0.25, depth=-0.001, transmission=Constant(gain_value=0.5))
    elsewhere = contact("a", "gone")
    assert AuthoredContacts.of("abc", "ab", (given, elsewhere)).over(found).to_contacts("abc") == (
        contact("b", "c", 2.0),
        given,
    )
    assert AuthoredContacts.of("abc", "ab", ()).over(found).to_contacts("abc") == (
        contact("b", "c", 2.0),
    )
    assert AuthoredContacts.of("abc", "a", ()).over(found).to_contacts("abc") == found.to_contacts(
        "abc"
    )


def test_nothing_found_and_nothing_authored():
    merged = AuthoredContacts.of("abc", "abc", ()).over(ContactSet.empty())
    assert len(merged) == 0 and merged.positions.shape == (0, 2, 3)


def test_a_tracer_follows_what_is_authored_from_frame_to_frame():
    """Two boxes on each other pass on half of it, by a function with bands; where the author says
    that they don't touch, nothing."""
    objects = tuple(
        HapticObject(name, 0.0, 1.0, function_from_dict({"function": "identity"}))
        for name in ("low", "top")
    )
    bodies = tuple(Body(name, Box((1, 1, 1))) for name in ("low", "top"))
    transforms = np.stack([np.eye(4), np.eye(4)])
    transforms[1, 2, 3] = 1.0
    source, listener = Source("s", "low"), Listener("l", "top", radius=0.0)
    dull = function_from_dict(
        {"function": "constant", "gain": 0.5, "band_gains": [1, 1, 1, 0.5, 0.25, 0]}
    )
    given = contact("low", "top", transmission=dull)
    functions = AuthoredContacts.of(("low", "top"), ("low", "top"), (given,))
    nothing = AuthoredContacts.of(("low", "top"), ("low", "top"), ())
    for lazy in (False, True):
        tracer = Tracer(lazy=lazy)
        for number, (authored, expected) in enumerate(
            ((None, 1.0), (functions, 0.5), (nothing, 0.0), (None, 1.0))
        ):
            frame = Frame(
                number,
                number / 25,
                objects,
                (source,),
                (listener,),
                Settings(),
                bodies,
                transforms,
                authored=authored,
            )
            result = tracer.step(frame)
            np.testing.assert_allclose(result.propagation.gain, [[expected]], rtol=1e-12)
            if authored is functions:
                np.testing.assert_allclose(
                    result.propagation.band_gain[0, 0],
                    0.5 * np.array([1, 1, 1, 0.5, 0.25, 0]),
                    rtol=1e-12,
                )
