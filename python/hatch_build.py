"""Puts the command and the libraries of its FMUs into the wheel, if COFFERDAM_PROGRAMS names the folder that holds them."""

import os
from pathlib import Path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

LIBRARIES = [f"lib{unit}_fmu.so" for unit in ("dam", "reservoir", "coupled")]
FILES = {"cofferdam": "cofferdam"} | {f"deps/{name}": name for name in LIBRARIES}


class Programs(BuildHookInterface):
    def initialize(self, version, build_data):
        folder = os.environ.get("COFFERDAM_PROGRAMS")
        if not folder or version == "editable":
            return
        paths = {Path(folder, file).resolve(): name for file, name in FILES.items()}
        missing = [str(path) for path in paths if not path.is_file()]
        if missing:
            raise FileNotFoundError(f"COFFERDAM_PROGRAMS: {', '.join(missing)}; run `cargo build --release` first")
        # The command looks for the libraries in its own folder.
        build_data["shared_scripts"] = {str(path): name for path, name in paths.items()}
        build_data["pure_python"] = False
        build_data["tag"] = "py3-none-linux_x86_64"
