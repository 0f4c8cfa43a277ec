"""Clients of Mitsubishi CR controllers: CR1, CRnD, CR750, CR800."""
