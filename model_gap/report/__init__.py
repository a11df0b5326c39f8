"""The result for people: one self-contained HTML page."""
