"""Benchmarks against other packages and against the uncertainty law; run with `make bench`."""
