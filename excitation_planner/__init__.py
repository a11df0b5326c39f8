"""How the robot should shake itself: range, direction, signal, limits, plan."""
