"""Blocks for diagrams: kinematics, sources, arms, sensors, and blocks of controllers."""
