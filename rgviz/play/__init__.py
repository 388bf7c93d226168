"""The mapping of a log, played: ``child`` maps in a process of its own, ``tape`` keeps what it told, ``player`` knows
what is on show, ``stage`` draws it, ``controls`` are what people press, ``playback`` ties them to the app."""
