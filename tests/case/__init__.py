"""Tests of what a case file says, and of what is said of it: nothing is solved."""
