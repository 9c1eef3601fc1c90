# SPDX-License-Identifier: BSD-3-Clause
"""Usage: check_mcap.py DIR NPM_DIR. npm's @mcap/core and rosmsg2-serialization read the MCAP files of write_recordings;
every value is compared. The packages of package-lock.json are installed into NPM_DIR. Exit status 77: no node or npm,
or no way to npm's packages."""
import base64
import json
import pathlib
import shutil
import subprocess
import sys

import expectation

HERE = pathlib.Path(__file__).resolve().parent


def install_readers(npm_dir):
    npm_dir.mkdir(parents=True, exist_ok=True)
    lock = npm_dir / "package-lock.json"
    if (npm_dir / "complete").exists() and lock.read_text() == (HERE / lock.name).read_text():
        return
    for name in ("package.json", "package-lock.json", ".npmrc"):
        shutil.copy(HERE / name, npm_dir / name)
    done = subprocess.run(["npm", "ci", "--ignore-scripts", "--fetch-retries", "1"], cwd=npm_dir, capture_output=True, text=True)
    if done.returncode != 0:
        print(f"skipped: npm cannot fetch the readers here\n{done.stdout}{done.stderr}")
        sys.exit(77)
    (npm_dir / "complete").touch()


def plain(value):
    """As the comparison wants it: times in ns, bytes as bytes."""
    if isinstance(value, dict):
        if set(value) == {"sec", "nanosec"} or set(value) == {"sec", "nsec"}:
            return value["sec"] * 10**9 + value.get("nanosec", value.get("nsec"))
        return {key: base64.b64decode(v) if key == "data" else plain(v) for key, v in value.items()}
    return [plain(v) for v in value] if isinstance(value, list) else value


def read_file(file, npm_dir, result):
    """What the file says about itself, and topic -> list of (type without package path, time_ns, message)."""
    done = subprocess.run(["node", HERE / "read_mcap.mjs", npm_dir, file], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{file.name}: node failed:\n{done.stderr}")
    about, *lines = map(json.loads, done.stdout.splitlines())
    messages = {}
    for line in lines:
        kind = line["type"].split("/")
        result.equal(kind[1], "msg", "type name of ROS 2")
        of_topic = messages.setdefault(line["topic"], [])
        result.equal(line["sequence"], len(of_topic), line["topic"] + " sequence")
        of_topic.append((kind[2], int(line["logTime"]), plain(line["message"])))
    result.expect(about["complete"], "the stream reader reached the end")
    return about, messages


def check_file(file, npm_dir, expected, compression):
    check = expectation.RosCheck(expected)
    result = check.result
    about, messages = read_file(file, npm_dir, result)
    check.check(messages)
    times = [time for of_topic in messages.values() for _, time, _ in of_topic]

    # Header and statistics of the file.
    result.equal([about["header"]["profile"], about["header"]["library"]], ["ros2", "swiftlet"], "header")
    statistics = about["statistics"]
    result.equal(int(statistics["messageCount"]), len(times), "message count")
    result.equal({k: int(n) for k, n in statistics["counts"].items()} == {k: len(m) for k, m in messages.items()}, True,
                 "counts of channels")
    result.equal([int(statistics["messageStartTime"]), int(statistics["messageEndTime"])], [min(times), max(times)], "span")
    result.equal(statistics["chunkCount"], about["records"]["Chunk"], "chunk count")
    result.equal(about["records"]["ChunkIndex"], about["records"]["Chunk"], "chunk indexes")
    result.equal({c["compression"] for c in about["chunks"]} == {compression}, True, "compression")
    result.equal(sorted(about["summaryOffsets"]), [0x03, 0x04, 0x08, 0x0B], "summary offsets")
    for channel in about["channels"]:
        result.equal([channel["encoding"], channel["schemaEncoding"]], ["cdr", "ros2msg"], "encodings")
        durability = "durability: 1" if channel["topic"] == "/tf_static" else "durability: 2"
        result.expect(durability in channel["qos"], channel["topic"] + " durability")
    return result.finish(f"@mcap/core {file.name}", least=5000)


def has_node():
    return bool(shutil.which("node") and shutil.which("npm"))


def main():
    if not has_node():
        print("skipped: this test needs node and npm")
        sys.exit(77)
    directory, npm_dir = map(pathlib.Path, sys.argv[1:])
    install_readers(npm_dir)
    expected = expectation.load(directory)
    failures = check_file(directory / "record.mcap", npm_dir, expected, "zstd")
    failures += check_file(directory / "plain.mcap", npm_dir, expected, "")
    rows = expectation.Comparison()
    expectation.check_rows(read_file(directory / "rows.mcap", npm_dir, rows)[1], directory, expected, rows)
    failures += rows.finish("@mcap/core rows.mcap", least=1000)
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
