"""Python functions beside the commands: arrays as programs, checks, simulated times, notebook
pages.
"""
