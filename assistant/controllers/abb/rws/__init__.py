"""Robot Web Services of ABB controllers; `client.Rws` is what they are used through."""
