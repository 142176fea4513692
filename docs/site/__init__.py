"""The documentation site: `python -m docs.site` makes it in build/site."""
