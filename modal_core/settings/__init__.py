"""What a setting or a field of a result is, written once beside it.

In come a dataclass and its words; out go checks, parameters of nodes and texts of documentation.
"""
