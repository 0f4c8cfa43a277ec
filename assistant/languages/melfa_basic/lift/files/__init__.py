"""A file as procedures, and the files of a program as one."""
