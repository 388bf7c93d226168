"""rgviz: the app. Command line, server, editor."""
