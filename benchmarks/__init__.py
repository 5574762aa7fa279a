"""Benchmarks of the product; ``python -m benchmarks`` runs all of them."""
