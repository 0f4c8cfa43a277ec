"""Shared parts of the checks of every language: how rules run, and the views that many of them
use.
"""
