"""What people see in a terminal of modes, plans, models and what changed.

In come results; out go tables and lines.
"""
