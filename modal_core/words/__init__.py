"""Words for people: flags, names, reasons, and text from elsewhere made fit to be shown.

In come names and texts; out go lines.
"""
