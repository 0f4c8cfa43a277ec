"""The resources of Robot Web Services, a file a service: one handler for both dialects each."""
