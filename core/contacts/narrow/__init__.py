"""Narrow phase: signed distances and contact manifolds of pairs of bodies."""
