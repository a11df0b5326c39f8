"""From a recording to its modes, with what should be known of them.

In come a recording, a robot and settings; out go modes with remarks, and files that other
programs read.
"""
