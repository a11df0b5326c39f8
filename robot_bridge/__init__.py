"""ABB controllers over EGM and Robot Web Services, and the operator's release of every motion.

In come plans; out go joint states and, after a person released and started one, its motion.
Recordings are replayed as if a robot were there.
"""
