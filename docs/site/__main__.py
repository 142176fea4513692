"""`python -m docs.site [FOLDER]` builds the site in FOLDER/site, by default build/docs/site."""

import sys
from importlib.util import find_spec
from pathlib import Path

from docs.site.build import build
from docs.site.repository_pages import ROOT

if missing := [name for name in ("zensical", "mkdocstrings", "matplotlib") if find_spec(name) is None]:
    sys.exit(f"there is no {' or '.join(missing)}: pip install -e '.[docs]'")
folder = (Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "build" / "docs").resolve()
faults = build(folder)
print("\n".join(faults) if faults else f"{folder / 'site' / 'index.html'}: no faults; external_links.txt beside it")
sys.exit(bool(faults))
