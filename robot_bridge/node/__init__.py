"""The bridge and the replay as ROS nodes.

In come plans, services and heartbeats; out go states, joint states and diagnostics. Nothing is
decided here but who is alone with a name.
"""
