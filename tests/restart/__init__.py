"""Tests of runs that are cut, killed or damaged, and go on."""
