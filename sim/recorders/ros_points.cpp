// SPDX-License-Identifier: BSD-3-Clause
#include "sim/recorders/ros_points.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace swiftlet::sim {
namespace {

// sensor_msgs/PointField: datatype.
enum Datatype : std::uint8_t { kUint8 = 2, kUint16 = 4, kUint32 = 6, kFloat32 = 7, kFloat64 = 8 };

struct Field {
  const char* name;
  std::uint32_t offset;
  Datatype datatype;
};

// ouster_ros::Point, as registered by its PCL macro: aligned to 16 bytes.
constexpr Field kOusterFields[] = {{"x", 0, kFloat32},          {"y", 4, kFloat32},       {"z", 8, kFloat32},
                                   {"intensity", 16, kFloat32}, {"t", 20, kUint32},       {"reflectivity", 24, kUint16},
                                   {"ring", 26, kUint16},       {"ambient", 28, kUint16}, {"range", 32, kUint32}};
// [bytes] Size of a point in this layout, as the other steps below.
constexpr std::uint32_t kOusterStep = 48;
// livox_ros_driver2, xfer_format 0 (PointXYZRTLT): packed.
constexpr Field kLivoxFields[] = {{"x", 0, kFloat32},          {"y", 4, kFloat32},  {"z", 8, kFloat32},
                                  {"intensity", 12, kFloat32}, {"tag", 16, kUint8}, {"line", 17, kUint8},
                                  {"timestamp", 18, kFloat64}};
constexpr std::uint32_t kLivoxStep = 26;
// velodyne_pointcloud, PointcloudXYZIRT: packed.
constexpr Field kVelodyneFields[] = {{"x", 0, kFloat32},          {"y", 4, kFloat32},    {"z", 8, kFloat32},
                                     {"intensity", 12, kFloat32}, {"ring", 16, kUint16}, {"time", 18, kFloat32}};
constexpr std::uint32_t kVelodyneStep = 22;
constexpr Field kSmallFields[] = {
    {"x", 0, kFloat32}, {"y", 4, kFloat32}, {"z", 8, kFloat32}, {"intensity", 12, kFloat32}};
constexpr std::uint32_t kSmallStep = 16;

template <class Number>
void store(std::byte* at, Number value) {
  std::memcpy(at, &value, sizeof value);
}

void store_xyz(std::byte* at, const Scan& scan, int i, float step_m) {
  if (!scan.hit(i)) return;  // the drivers write zeros for an empty return; the memory is already zero
  Eigen::Vector3f point = scan.point_lidar(i);
  if (step_m > 0.0F) point = (point / step_m).array().round() * step_m;
  std::memcpy(at, point.data(), 3 * sizeof(float));
}

std::uint32_t offset_ns(const Scan& scan, int i) { return static_cast<std::uint32_t>(scan.time_of(i) - scan.stamp); }

/// Rows in firing order within a column.
std::vector<int> firing_order(const BeamTable& beams) {
  std::vector<int> rows(static_cast<std::size_t>(beams.rows));
  std::iota(rows.begin(), rows.end(), 0);
  if (!beams.row_offset_s.empty()) {
    std::stable_sort(rows.begin(), rows.end(),
                     [&](int a, int b) { return beams.row_offset_s[a] < beams.row_offset_s[b]; });
  }
  return rows;
}

/// All fields of PointCloud2 before its data.
void encode_description(std::uint32_t sequence, const Scan& scan, const std::string& frame, int width, int height,
                        std::span<const Field> fields, std::uint32_t step, RosEncoder& out) {
  out.begin();
  out.header(sequence, scan.stamp, frame);
  out.put(static_cast<std::uint32_t>(height));
  out.put(static_cast<std::uint32_t>(width));
  out.count(fields.size());
  for (const Field& field : fields) {
    out.text(field.name);
    out.put(field.offset);
    out.put(static_cast<std::uint8_t>(field.datatype));
    out.put(std::uint32_t{1});
  }
  out.put(false);  // little-endian
  out.put(step);
  out.put(step * static_cast<std::uint32_t>(width));
}

/// Organized by rows; empty returns are zeros.
void encode_ouster(const Scan& scan, float step_m, std::uint32_t sequence, const std::string& frame, RosEncoder& out) {
  encode_description(sequence, scan, frame, scan.cols(), scan.rows(), kOusterFields, kOusterStep, out);
  std::byte* at = out.blob(static_cast<std::size_t>(scan.size()) * kOusterStep);
  for (int i = 0; i < scan.size(); ++i, at += kOusterStep) {
    store_xyz(at, scan, i, step_m);
    store(at + 20, offset_ns(scan, i));
    store(at + 26, static_cast<std::uint16_t>(i / scan.cols()));
    if (!scan.hit(i)) continue;
    store(at + 16, scan.intensity[i]);
    store(at + 24, static_cast<std::uint16_t>(reflectivity_byte(scan.reflectivity[i], 100)));
    store(at + 32, static_cast<std::uint32_t>(std::lround(scan.range_from_axis_m(i) * 1000.0F)));
  }
}

/// One row in order of time; empty returns are zeros.
void encode_livox(const Scan& scan, float step_m, std::uint32_t sequence, const std::string& frame, RosEncoder& out) {
  encode_description(sequence, scan, frame, scan.size(), 1, kLivoxFields, kLivoxStep, out);
  std::byte* at = out.blob(static_cast<std::size_t>(scan.size()) * kLivoxStep);
  const std::vector<int> rows = firing_order(*scan.beams);
  for (int column = 0; column < scan.cols(); ++column) {
    for (const int row : rows) {
      const int i = row * scan.cols() + column;
      store_xyz(at, scan, i, step_m);
      if (scan.hit(i)) store(at + 12, static_cast<float>(reflectivity_byte(scan.reflectivity[i], 150)));
      store(at + 17, static_cast<std::uint8_t>(row));
      store(at + 18, static_cast<double>(out.recorded(scan.time_of(i))));
      at += kLivoxStep;
    }
  }
}

/// One row in order of time, without empty returns.
void encode_velodyne(const Scan& scan, float step_m, std::uint32_t sequence, const std::string& frame,
                     RosEncoder& out) {
  int num_points = 0;
  for (int i = 0; i < scan.size(); ++i) num_points += scan.hit(i) ? 1 : 0;
  encode_description(sequence, scan, frame, num_points, 1, kVelodyneFields, kVelodyneStep, out);
  std::byte* at = out.blob(static_cast<std::size_t>(num_points) * kVelodyneStep);
  const std::vector<int> rows = firing_order(*scan.beams);
  for (int column = 0; column < scan.cols(); ++column) {
    for (const int row : rows) {
      const int i = row * scan.cols() + column;
      if (!scan.hit(i)) continue;
      store_xyz(at, scan, i, step_m);
      store(at + 12, static_cast<float>(reflectivity_byte(scan.reflectivity[i], 100)));
      store(at + 16, static_cast<std::uint16_t>(scan.rows() - 1 - row));  // the driver counts rings from below
      store(at + 18, static_cast<float>(to_seconds(scan.time_of(i) - scan.stamp)));
      at += kVelodyneStep;
    }
  }
}

/// One row in the order of the scan, without empty returns.
void encode_small(const Scan& scan, float step_m, std::uint32_t sequence, const std::string& frame, RosEncoder& out) {
  int num_points = 0;
  for (int i = 0; i < scan.size(); ++i) num_points += scan.hit(i) ? 1 : 0;
  encode_description(sequence, scan, frame, num_points, 1, kSmallFields, kSmallStep, out);
  std::byte* at = out.blob(static_cast<std::size_t>(num_points) * kSmallStep);
  for (int i = 0; i < scan.size(); ++i) {
    if (!scan.hit(i)) continue;
    store_xyz(at, scan, i, step_m);
    store(at + 12, static_cast<float>(reflectivity_byte(scan.reflectivity[i], 100)));
    at += kSmallStep;
  }
}

PointsLayout layout_for(PointsLayout layout, const Scan& scan) {
  if (layout != PointsLayout::kAuto) return layout;
  if (scan.rows() == 4) return PointsLayout::kLivox;
  return scan.rows() == 16 || scan.rows() == 32 ? PointsLayout::kVelodyne : PointsLayout::kOuster;
}

}  // namespace

void encode_points(const Scan& scan, PointsLayout layout, float step_m, std::uint32_t sequence,
                   const std::string& frame, RosEncoder& out) {
  switch (layout_for(layout, scan)) {
    case PointsLayout::kAuto:
    case PointsLayout::kOuster:
      encode_ouster(scan, step_m, sequence, frame, out);
      break;
    case PointsLayout::kLivox:
      encode_livox(scan, step_m, sequence, frame, out);
      break;
    case PointsLayout::kVelodyne:
      encode_velodyne(scan, step_m, sequence, frame, out);
      break;
    case PointsLayout::kSmall:
      encode_small(scan, step_m, sequence, frame, out);
      break;
  }
  out.put(true);  // dense: no NaN
}

std::uint8_t reflectivity_byte(float reflectivity, int diffuse_max) {
  const float diffuse = static_cast<float>(diffuse_max);
  if (!(reflectivity > 0.0F)) return 0;
  if (reflectivity <= 1.0F) return static_cast<std::uint8_t>(std::lround(diffuse * reflectivity));
  const float decades = std::min(std::log10(reflectivity) / 3.0F, 1.0F);
  return static_cast<std::uint8_t>(std::lround(diffuse + (255.0F - diffuse) * decades));
}

}  // namespace swiftlet::sim
