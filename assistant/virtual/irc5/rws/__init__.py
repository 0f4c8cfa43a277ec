"""Robot Web Services as the virtual IRC5 serves them, in both dialects."""
