"""Keys of a case that stand above its tables."""

ABOUT = ("title", "authors", "license")  # they tell of it and decide nothing
