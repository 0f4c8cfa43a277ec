"""Trees changed in place: what two built trees differ in, made to the one that was read."""
