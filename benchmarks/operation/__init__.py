"""Identification while the robot works: our methods and the peers on an arm that mills."""
