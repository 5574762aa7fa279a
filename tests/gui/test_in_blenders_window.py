import re
from pathlib import Path

SCENARIOS = Path(__file__).parent / "scenarios"
TROUBLE = re.compile(r"Traceback|Error|Warning: (?!.*(?:XDG_RUNTIME_DIR|driver))|rna_uiItem")


def without_trouble(printed: str) -> bool:
    lines = [line for line in printed.splitlines() if TROUBLE.search(line)]
    assert lines == [], printed
    return True


def test_installs_from_the_zip(installed):
    assert 'Installed "haptic_tracing"' in installed
    assert without_trouble(installed)


def test_sidebar(play):
    report, printed = play(SCENARIOS / "sidebar.py")
    assert report["error"] is None, report["error"]
    assert report["seen"] == {"haptic": True, "haptic after undo": False, "haptic after redo": True, "left after disabling": {}}
    assert without_trouble(printed)
