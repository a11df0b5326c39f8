"""Methods of the identifier side by side, behind a spindle and on modes that move."""
