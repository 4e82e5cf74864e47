"""Tests of the scripts and of the kept numbers of `make verify` and `make bench`."""
