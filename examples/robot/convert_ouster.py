#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Converts a capture of an Ouster's packets to the files that recorded_slam reads.

    convert_ouster.py RECORD.pcap METADATA.json OUT

OUT gets sweeps as PCD files with pcd_index.csv, imu.csv, and mount.txt, with the frame of the sensor's IMU as the body frame.
METADATA.json is the sensor's own description. As a module it gives the same as arrays: `read`.
"""
import json
import pathlib
import struct
import sys

import numpy as np

# Bytes of a pixel, bits of its range, and the unit of the range [m], by profile of the LiDAR's packets (firmware 2.2 on).
PROFILES = {"RNG15_RFL8_NIR8": (4, 15, 0.008), "RNG19_RFL8_SIG16_NIR16": (12, 19, 0.001), "RNG19_RFL8_SIG16_NIR16_DUAL": (16, 19, 0.001)}
PACKET_HEADER, PACKET_FOOTER, COLUMN_HEADER, IMU_PACKET = 32, 32, 12, 48  # bytes
STANDARD_GRAVITY = 9.80665  # [m/s^2]; the IMU reports g


def payloads(pcap):
    """Payloads of the UDP packets over IPv4 in a pcap of Ethernet frames; fragments are joined."""
    data = pathlib.Path(pcap).read_bytes()
    order = {b"\xd4\xc3\xb2\xa1": "<", b"\x4d\x3c\xb2\xa1": "<", b"\xa1\xb2\xc3\xd4": ">", b"\xa1\xb2\x3c\x4d": ">"}.get(data[:4])
    if order is None:
        raise ValueError(f"{pcap}: expected a pcap file, found one that begins with {data[:4].hex()}")
    at, parts = 24, {}
    while at + 16 <= len(data):
        size = struct.unpack(order + "8xI4x", data[at:at + 16])[0]
        frame, at = data[at + 16:at + 16 + size], at + 16 + size
        if frame[12:14] != b"\x08\x00" or frame[23] != 17:  # not UDP over IPv4
            continue
        ip = frame[14:]
        length, number, flags = struct.unpack(">2xHHH", ip[:8])
        part = ip[4 * (ip[0] & 15):length]
        parts.setdefault(number, []).append(part)
        if not flags & 0x2000:  # last fragment
            yield b"".join(parts.pop(number))[8:]


def read(pcap, metadata):
    """Sweeps, IMU samples and T_body_lidar (4, 4) of a capture; the body frame is that of the IMU.

    A sweep is a dict: t_ns, of its first column; range_m (rows, cols), 0: no return; directions_lidar and origins_lidar_m
    (rows, cols, 3); offset_s (cols,). A sample of the IMU is (t_ns, body rate (3,) [rad/s], specific force (3,) [m/s^2]).
    """
    about = json.loads(pathlib.Path(metadata).read_text())
    layout = about["data_format"]
    profile = layout.get("udp_profile_lidar", "LEGACY")
    if profile not in PROFILES:
        raise ValueError(f"{metadata}: udp_profile_lidar: expected one of {', '.join(PROFILES)}, found {profile}")
    pixel_bytes, range_bits, unit_m = PROFILES[profile]
    rows, cols, per_packet = layout["pixels_per_column"], layout["columns_per_frame"], layout["columns_per_packet"]
    column_bytes = COLUMN_HEADER + rows * pixel_bytes
    packet_bytes = PACKET_HEADER + per_packet * column_bytes + PACKET_FOOTER
    frames, imu = {}, []
    for payload in payloads(pcap):
        if len(payload) == IMU_PACKET:
            t_ns, *values = struct.unpack("<8xQ8x6f", payload)
            imu.append((t_ns, np.radians(values[3:]), STANDARD_GRAVITY * np.array(values[:3])))
        elif len(payload) == packet_bytes:
            frame = struct.unpack("<H", payload[2:4])[0]
            columns = frames.setdefault(frame, {})
            for i in range(per_packet):
                column = payload[PACKET_HEADER + i * column_bytes:][:column_bytes]
                t_ns, number, status = struct.unpack("<QHH", column[:COLUMN_HEADER])
                pixels = np.frombuffer(column, "u1", offset=COLUMN_HEADER).reshape(rows, pixel_bytes)
                if status & 1:
                    columns[number] = t_ns, pixels[:, :4].copy().view("<u4")[:, 0] & (1 << range_bits) - 1
    sweeps = [sweep_of(about, columns, unit_m) for columns in frames.values() if columns]
    T_body_sensor, T_sensor_lidar = (np.array(about[name + "_to_sensor_transform"]).reshape(4, 4) for name in ("imu", "lidar"))
    T_body_lidar = np.linalg.inv(T_body_sensor) @ T_sensor_lidar
    T_body_lidar[:3, 3] /= 1000  # millimeters
    return sweeps, imu, T_body_lidar


def sweep_of(about, columns, unit_m):
    """Directions and origins by the manual of the sensor: the beam begins where it leaves the rotating head."""
    number = np.array(sorted(columns, key=lambda n: columns[n][0]))
    t_ns = np.array([columns[n][0] for n in number])
    origin_m = about["lidar_origin_to_beam_origin_mm"] / 1000
    encoder = 2 * np.pi * (1 - number / about["data_format"]["columns_per_frame"])
    azimuth = encoder - np.radians(about["beam_azimuth_angles"])[:, None]
    elevation = np.radians(about["beam_altitude_angles"])[:, None]
    directions = np.stack([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation),
                           np.broadcast_to(np.sin(elevation), azimuth.shape)], axis=2)
    origins_m = np.broadcast_to(origin_m * np.stack([np.cos(encoder), np.sin(encoder), 0 * encoder], axis=1), directions.shape)
    range_m = unit_m * np.stack([columns[n][1] for n in number], axis=1)
    range_m = np.where(range_m > origin_m, range_m - origin_m, 0)
    return {"t_ns": int(t_ns[0]), "range_m": range_m, "directions_lidar": directions, "origins_lidar_m": origins_m,
            "offset_s": (t_ns - t_ns[0]) / 1e9}


def write(out, sweeps, imu, T_body_lidar):
    """The files of recorded_slam; times begin at the first column of the first sweep."""
    out = pathlib.Path(out)
    out.mkdir(parents=True)
    begin_ns = sweeps[0]["t_ns"]
    index = ["file,start_s,duration_s"]
    for i, sweep in enumerate(sweeps):
        hit = sweep["range_m"] > 0
        points = np.zeros(hit.sum(), [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("t", "<u4")])
        xyz = sweep["origins_lidar_m"] + sweep["range_m"][..., None] * sweep["directions_lidar"]
        points["x"], points["y"], points["z"] = xyz[hit].T
        points["t"] = np.rint(np.broadcast_to(1e9 * sweep["offset_s"], hit.shape)[hit])
        head = (f"VERSION 0.7\nFIELDS x y z t\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH {len(points)}\nHEIGHT 1\n"
                f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(points)}\nDATA binary\n")
        (out / f"{i:06}.pcd").write_bytes(head.encode() + points.tobytes())
        index.append(f"{i:06}.pcd,{(sweep['t_ns'] - begin_ns) / 1e9:.9f},{sweep['offset_s'][-1]:.9f}")
    rows = ["time_s,omega_x_radps,omega_y_radps,omega_z_radps,f_x_mps2,f_y_mps2,f_z_mps2"]
    rows += [",".join([f"{(t_ns - begin_ns) / 1e9:.9f}", *(f"{v:.9g}" for v in (*omega, *force))]) for t_ns, omega, force in imu]
    (out / "pcd_index.csv").write_text("\n".join(index) + "\n")
    (out / "imu.csv").write_text("\n".join(rows) + "\n")
    (out / "mount.txt").write_text("".join(" ".join(f"{v:.9g}" for v in row) + "\n" for row in T_body_lidar))


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit("usage: convert_ouster.py RECORD.pcap METADATA.json OUT")
    write(sys.argv[3], *read(*sys.argv[1:3]))
