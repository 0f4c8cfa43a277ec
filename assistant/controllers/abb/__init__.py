"""Clients of ABB controllers: the IRC5 and OmniCore."""
