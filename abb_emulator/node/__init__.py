"""The emulated cell as a ROS node.

In come parameters and faults to inject; out go measurements, joint states and the true modes.
"""
