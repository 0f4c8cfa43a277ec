"""Two programs run against the same signals, and what they do compared.

`sides` says how the programs of each language run. `wires` are the signals that both have, whatever
each calls them. A `Scenario` tells what they read, by what has happened so far, so that it is the
same for both; `driver` plays one, and answers waits that nobody else ends. `search` looks for
scenarios that take every branch of both programs.
"""
