"""`python -m docs.site [FOLDER]` builds the site in FOLDER/site, by default build/docs/site."""

import sys
from pathlib import Path

from docs.site.build import build
from docs.site.repository_pages import ROOT

folder = (Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "build" / "docs").resolve()
faults = build(folder)
print("\n".join(faults) if faults else f"{folder / 'site' / 'index.html'}: no faults; external_links.txt beside it")
sys.exit(bool(faults))
