# SPDX-License-Identifier: BSD-3-Clause
"""Usage: check_octomap.py DIR. Debian's octomap-tools open the octrees of write_recordings, and count their occupied cells."""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import expectation


def main():
    directory = pathlib.Path(sys.argv[1])
    if shutil.which("bt2vrml") is None or shutil.which("convert_octree") is None:
        print("octomap-tools are not installed")
        return 77
    result = expectation.Comparison()
    maps = {m["name"]: m for m in expectation.load(directory)["maps"]}
    with tempfile.TemporaryDirectory() as folder:
        for path in sorted((directory / "maps").glob("*.[bo]t")):
            binary = pathlib.Path(folder) / (path.stem + ".bt")
            if path.suffix == ".ot":
                subprocess.run(["convert_octree", path, binary], check=True, capture_output=True)
            else:
                shutil.copy(path, binary)
            printed = subprocess.run(["bt2vrml", binary], check=True, capture_output=True, text=True)
            count = int(re.search(r"Finished writing (\d+) voxels", printed.stdout + printed.stderr).group(1))
            wanted = maps[path.stem.split("_")[1]]
            occupied = sum(voxel[3] >= wanted["occupied_from"] for voxel in wanted["voxels"])
            result.equal(count, occupied, f"{path}: occupied cells")
    return result.finish("octomap-tools", 4)


if __name__ == "__main__":
    sys.exit(main())
