"""Files that may come from anywhere, read within bounds and written whole.

In come paths; out go checked contents, one clear error, or a file that is written or not at all.
"""
