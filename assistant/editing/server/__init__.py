"""The service as a language server; its library is loaded with it."""
