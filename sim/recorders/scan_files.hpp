// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/sim/io/byte_buffer.hpp"
#include "swiftlet/sim/recorders/pose_history.hpp"
#include "swiftlet/sim/recorders/scan_files_config.hpp"
#include "swiftlet/sim/recording/recorder.hpp"
#include "swiftlet/sim/world/labeled_scan.hpp"

namespace swiftlet::sim {

/// A stored value of each point.
struct PointField {
  enum class Type { kFloat32, kUint8, kUint16, kUint32 };
  const char* name;
  Type type;
  int size_bytes;
};
/// The fields of a point in their order: packed, little-endian, without padding.
std::span<const PointField> point_fields();

/// Layout of the points, for a file's header.
struct CloudLayout {
  int width = 0, height = 0;  ///< organized: columns and rows of the scan; compact: number of points and 1
  std::string frame;
  TimeNs stamp = 0;
};

/// One file format: the point data is the same in all formats, after the format's own header.
struct CloudFormat {
  const char* extension;
  bool organized;  ///< keep empty returns, as NaN
  std::string (*header)(const CloudLayout& layout);
};

/// Appends the points of a scan in the layout of point_fields(), row by row. `T_frame_lidar` per column, or one for
/// all; empty: points stay in the lidar frame. Returns the number of points.
int put_points(const LabeledScan& scan, std::span<const Pose> T_frame_lidar, bool organized, ByteBuffer& out);

/// Writes FOLDER/VEHICLE_SENSOR/%06d.EXTENSION and an index of them, FOLDER/VEHICLE_SENSOR/EXTENSION_index.csv.
std::unique_ptr<Recorder> make_scan_files_recorder(const ScanFilesConfig& config, const CloudFormat& format);

}  // namespace swiftlet::sim
