"""The script that installs Debian packages, with dpkg, sudo and apt-get replaced by programs that
note how they are called."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="a shell script")

PROGRAMS = {
    "dpkg-query": 'case "$*" in *libegl1 | *umockdev) exit 1 ;; *) echo installed ;; esac',
    "id": 'echo "$FAKE_USER"',
    "sudo": 'echo "sudo $*" >>"$CALLS"; [ "$FAKE_SUDO" = free ] || exit 1; shift; "$@"',
    "apt-get": 'echo "apt-get $*" >>"$CALLS"',
}


@pytest.fixture
def install(root, tmp_path):
    """Runs the script for ``purpose`` and returns the finished process and the calls it made."""
    for name, text in PROGRAMS.items():
        path = tmp_path / name
        path.write_text(f"#!{shutil.which('sh')}\n{text}\n", encoding="utf-8")
        path.chmod(0o755)

    def run(purpose, user, sudo):
        calls = tmp_path / "calls"
        calls.write_text("", encoding="utf-8")
        path = os.pathsep.join(
            [str(tmp_path), str(Path(sys.executable).parent), os.environ["PATH"]]
        )
        environment = os.environ | {
            "PATH": path,
            "CALLS": str(calls),
            "FAKE_USER": user,
            "FAKE_SUDO": sudo,
        }
        done = subprocess.run(
            [root / "packaging" / "system_packages", purpose],
            env=environment,
            capture_output=True,
            text=True,
        )
        return done, [
            line
            for line in calls.read_text(encoding="utf-8").splitlines()
            if line != "sudo -n true"
        ]

    return run


@pytest.mark.parametrize(
    ("purpose", "missing"), [("demo", "libegl1"), ("test", "libegl1 umockdev")]
)
def test_root_installs_what_is_missing_and_says_so(install, purpose, missing):
    done, calls = install(purpose, user="0", sudo="asks")
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == f"haptic-tracing: installing the Debian packages {missing}"
    assert [call.split()[:2] for call in calls] == [["apt-get", "update"], ["apt-get", "install"]]
    assert calls[1].endswith(f"--no-install-recommends {missing}")


def test_sudo_without_a_password_installs_as_well(install):
    done, calls = install("demo", user="1000", sudo="free")
    assert done.returncode == 0, done.stderr
    assert "installing the Debian packages libegl1" in done.stdout
    assert any(call.startswith("apt-get install") and call.endswith(" libegl1") for call in calls)
    assert all(call.startswith(("sudo -n ", "apt-get ")) for call in calls)


def test_without_either_they_are_named_and_nothing_is_installed(install):
    done, calls = install("test", user="1000", sudo="asks")
    assert done.returncode == 1
    assert done.stderr.strip().endswith("sudo apt-get install libegl1 umockdev")
    assert calls == []
