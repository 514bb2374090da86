"""Opens the site: the pages with a search, in a browser and without a network (tools/docs.sh builds it)."""

import webbrowser
from pathlib import Path

import quoin_tools
from quoin_tools.base.command import Parser
from quoin_tools.base.solver import CHECKOUT

DESCRIPTION = "Opens the documents as pages with a search, in the browser; no network is needed."


class SiteError(ValueError):
    """There is no site; the message is one line."""


def folders():
    """Returns where the site may be: of an installed package, of the checkout."""
    return [Path(quoin_tools.__file__).parent / "site", CHECKOUT / "build/site"]


def main(words):
    Parser(prog="quoin help --site", description=DESCRIPTION).parse_args(words)
    found = [folder / "index.html" for folder in folders() if (folder / "index.html").is_file()]
    if not found:
        raise SiteError("the site is not built: tools/docs.sh in a checkout builds it")
    print(found[0].as_uri())
    webbrowser.open(found[0].as_uri())
    return 0
