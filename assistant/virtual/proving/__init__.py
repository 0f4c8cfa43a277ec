"""Two programs run against the same signals, and what they do compared.

`compared_programs` runs a program of each language. A `Scenario` states what both read, by what has
happened so far, so that it is the same for both; `driver` plays one, names the signals that both
have, and ends their waits. `search` looks for scenarios that take every branch of both programs.
`comparison` compares the events of two runs.
"""
