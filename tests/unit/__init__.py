"""Tests of formulas, records and readings: neither a mesh nor a case is needed."""
