# Types of quoin.py for programs that import it: a module of one file cannot say by itself that it has types.
from collections.abc import Sequence

from quoin_tools.base.results import Stage as Stage
from quoin_tools.front.python import BlockMesh as BlockMesh
from quoin_tools.front.python import MeshError as MeshError
from quoin_tools.front.python import Results as Results
from quoin_tools.front.python import RunError as RunError
from quoin_tools.front.python import mesh as mesh
from quoin_tools.front.python import run as run

__version__: str

def main(words: Sequence[str] | None = None) -> int: ...
