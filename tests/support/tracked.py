"""Files of the project, for the tests of tests/house."""
import subprocess


def tracked(root, *patterns):
    """Paths below `root` that git tracks and that exist; in a copy without git, all files outside of build/."""
    listed = subprocess.run(["git", "-C", str(root), "ls-files", "-z", *patterns], capture_output=True, text=True)
    if listed.returncode != 0:
        found = {p for pattern in patterns or ("*",) for p in root.rglob(pattern)}
        return sorted(p for p in found if p.is_file() and "build" not in p.relative_to(root).parts)
    return [root / name for name in listed.stdout.split("\0") if name and (root / name).is_file()]
