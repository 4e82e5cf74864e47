"""Pages without what is the same on all of them."""

from staffa.report.embedding import scripts


def without_scripts(page: str) -> str:
    """Return the text of a page without the scripts of staffa, which are long."""
    for own in scripts():
        page = page.replace(f"<script>{own}</script>", "", 1)
    return page
