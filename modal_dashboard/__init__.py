"""The live page: what a robot's vibration is now, in a browser.

In come results, diagrams, diagnostics and the states of bridge and planner; out goes a page that
shows them, read-only, to as many browsers as look.
"""
