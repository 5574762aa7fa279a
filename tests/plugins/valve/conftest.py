"""Fixtures of devices that umockdev makes up."""

from umockdev_runs import scene, under_umockdev  # noqa: F401
