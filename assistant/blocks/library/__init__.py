"""Blocks for diagrams: kinematics, sources, arms, and those that speak with controllers."""
