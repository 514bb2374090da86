"""What pyproject.toml cannot say: the version is that of CMakeLists.txt, and what is built on the way is no part of the tree."""

import re
import tempfile
from pathlib import Path

from setuptools import setup

project = Path(__file__).with_name("CMakeLists.txt").read_text(encoding="utf-8")
version = re.search(r"^project\(quoin VERSION (\S+)", project, flags=re.M)[1]
with tempfile.TemporaryDirectory(prefix="quoin-") as folder:
    setup(version=version, options={"build": {"build_base": folder}, "egg_info": {"egg_base": folder}})
