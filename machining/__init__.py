"""The cut that does not chatter: forces of milling, stability, tools joined to a machine.

In come modes or a frequency response at the tool, a cutter and a material; out go limiting
depths over spindle speed with the chance of chatter.  Knows nothing of robots or files of them.
"""
