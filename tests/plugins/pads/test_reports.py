"""Reports of these pads against published protocol facts."""

import pytest
from published_reports import check, rumble, vectors_of

VECTORS = vectors_of(__file__)
ENCODED = {
    "xbox_bt_l0.5_r0.25": lambda v: rumble("luna"),
    "luna_bt_l0.5_r0.25": lambda v: rumble("luna"),
    "shield2017_l0.5_r0.25_seq0": lambda v: rumble("shield-2017"),
    "shield2015_l0.5_r0.25": lambda v: rumble("shield-2015"),
    "8bitdo_l0.5_r0.25": lambda v: rumble("8bitdo"),
    "sinput_erm_l0.5_r0.25": lambda v: rumble("sinput"),
}


@pytest.mark.parametrize("name", VECTORS)
def test_report_is_byte_exact(name):
    check(ENCODED[name](VECTORS[name]), VECTORS[name])
