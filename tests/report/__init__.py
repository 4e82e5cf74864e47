"""Tests of results: tables, pictures, pages and comparisons, mostly of drawn runs."""
