"""Campaigns of arms that a multibody engine simulates (MuJoCo), with effects hidden in them.

The engine has its own rigid-body recursion (Featherstone's, in MuJoCo), nonlinear and about no
pose; springs, friction, play and stops are written from other equations than the suite's laws.
"""
