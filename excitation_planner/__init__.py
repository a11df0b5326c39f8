"""How the robot should shake itself: in come a robot and a request, out goes a sealed plan.

The method is that of Jiao et al. (2025), doi:10.1038/s41598-025-95339-6: small random motions of
several joints, within the range where natural frequencies stay.  ``planner.py`` read from top to
bottom is the whole of it; the folders are its steps: ``pose_range``, ``motion``, ``forecast``,
``drawing``, ``bounds``, then ``ways`` to the start and ``rapid`` for controllers that play a
program.
"""
