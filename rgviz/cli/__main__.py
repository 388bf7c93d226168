"""`python -m rgviz.cli`."""

import sys

from rgviz.cli import main

sys.exit(main())
