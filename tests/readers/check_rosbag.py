# SPDX-License-Identifier: BSD-3-Clause
"""Usage: check_rosbag.py DIR. Debian's rosbag reads the bags of write_recordings; every value is compared."""
import importlib
import pathlib
import subprocess
import sys

import genpy
import rosbag

import expectation


def plain(value):
    """A message as nested dicts; times in ns."""
    if isinstance(value, genpy.Time):
        return value.to_nsec()
    if isinstance(value, genpy.Message):
        return {name: plain(getattr(value, name)) for name in value.__slots__}
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    return value


def check_tools(bag):
    """rosbag check compares the types with the message packages that Debian ships. It goes by the text with its
    comments, which the bag leaves out, so it lists every type as a change from itself to itself."""
    check = subprocess.run(["/usr/bin/python3", "/usr/bin/rosbag", "check", str(bag)], capture_output=True, text=True)
    info = subprocess.run(["/usr/bin/python3", "/usr/bin/rosbag", "info", "--yaml", str(bag)], capture_output=True,
                          text=True)
    ready = "does not need any migrations" in check.stdout or "Bag is ready to be migrated" in check.stdout
    ok = ready and check.returncode == 0 and info.returncode == 0 and "version: 2.0" in info.stdout and "indexed: True" in info.stdout
    if not ok:
        print(check.stdout + check.stderr + info.stdout + info.stderr)
    return ok


def read_bag(reader):
    """topic -> list of (type without package path, time_ns, message)."""
    messages = {}
    for topic, message, t in reader.read_messages():
        messages.setdefault(topic, []).append((message._type.split("/")[1], t.to_nsec(), plain(message)))
    return messages


def check_content(bag, expected, compression):
    check = expectation.RosCheck(expected, first_time_ns=1, first_stamp_ns=0)
    with rosbag.Bag(str(bag)) as reader:
        check.result.equal(reader.get_compression_info().compression, compression, "compression")
        for info in reader._get_connections():  # as the bag carries them
            package, name = info.datatype.split("/")
            shipped = getattr(importlib.import_module(package + ".msg"), name)
            check.result.equal(info.md5sum, shipped._md5sum, f"{info.topic} md5")
            # The type made from the definition in the bag alone must be the shipped one.
            made = genpy.dynamic.generate_dynamic(info.datatype, info.msg_def)[info.datatype]
            check.result.equal(made._md5sum, shipped._md5sum, f"{info.topic} definition")
            check.result.equal(info.header["latching"].decode(), "1" if info.topic == "/tf_static" else "0",
                               f"{info.topic} latching")
        messages = read_bag(reader)
        for topic, of_topic in messages.items():
            numbers = [message["header"]["seq"] for _, _, message in of_topic if "header" in message]
            check.result.equal(numbers, list(range(len(numbers))), f"{topic} seq")
        check.result.equal(reader.get_message_count(), sum(map(len, messages.values())), "message count")
    check.check(messages)
    return check.result.finish(f"rosbag {bag.name}", least=5000)


def check_rows(bag, directory, expected):
    """Types that only the bag knows: its fingerprints must be those that genpy makes of its definitions."""
    result = expectation.Comparison()
    with rosbag.Bag(str(bag)) as reader:
        for info in reader._get_connections():
            made = genpy.dynamic.generate_dynamic(info.datatype, info.msg_def)[info.datatype]
            result.equal(made._md5sum, info.md5sum, f"{info.topic} fingerprint")
        expectation.check_rows(read_bag(reader), directory, expected, result, first_stamp_ns=0)
    return result.finish(f"rosbag {bag.name}", least=1000)


def main():
    directory = pathlib.Path(sys.argv[1])
    expected = expectation.load(directory)
    failures = 0
    for name, compression in (("record.bag", "lz4"), ("plain.bag", "none")):
        failures += not check_tools(directory / name)
        failures += check_content(directory / name, expected, compression)
    failures += check_rows(directory / "rows.bag", directory, expected)
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
