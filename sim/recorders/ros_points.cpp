// SPDX-License-Identifier: BSD-3-Clause
#include "sim/recorders/ros_points.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace swiftlet::sim {
namespace {

/// Values of sensor_msgs/PointField.datatype.
enum Datatype : std::uint8_t { kUint8 = 2, kUint16 = 4, kUint32 = 6, kFloat32 = 7, kFloat64 = 8 };

/// One number of a point: sensor_msgs/PointField. The offset is in bytes from the beginning of the point.
struct Field {
  const char* name;
  std::uint32_t offset;
  Datatype datatype;
};

// Each layout has the offsets [bytes] of the fields that its encoder writes (x, y and z begin every point), the list of
// all fields, and the size of a point [bytes] as point_step.

// Layout of ouster_ros::Point, as registered by its PCL macro: aligned to 16 bytes.
constexpr std::uint32_t kOusterIntensity = 16, kOusterTime = 20, kOusterReflectivity = 24, kOusterRing = 26,
                        kOusterRange = 32;
constexpr Field kOusterFields[] = {{"x", 0, kFloat32},
                                   {"y", 4, kFloat32},
                                   {"z", 8, kFloat32},
                                   {"intensity", kOusterIntensity, kFloat32},
                                   {"t", kOusterTime, kUint32},
                                   {"reflectivity", kOusterReflectivity, kUint16},
                                   {"ring", kOusterRing, kUint16},
                                   {"ambient", 28, kUint16},
                                   {"range", kOusterRange, kUint32}};
constexpr std::uint32_t kOusterStep = 48;

// Layout of livox_ros_driver2 with xfer_format 0 (PointXYZRTLT): packed.
constexpr std::uint32_t kLivoxIntensity = 12, kLivoxLine = 17, kLivoxTimestamp = 18;
constexpr Field kLivoxFields[] = {{"x", 0, kFloat32},
                                  {"y", 4, kFloat32},
                                  {"z", 8, kFloat32},
                                  {"intensity", kLivoxIntensity, kFloat32},
                                  {"tag", 16, kUint8},
                                  {"line", kLivoxLine, kUint8},
                                  {"timestamp", kLivoxTimestamp, kFloat64}};
constexpr std::uint32_t kLivoxStep = 26;

// Layout of velodyne_pointcloud (PointcloudXYZIRT): packed.
constexpr std::uint32_t kVelodyneIntensity = 12, kVelodyneRing = 16, kVelodyneTime = 18;
constexpr Field kVelodyneFields[] = {{"x", 0, kFloat32},
                                     {"y", 4, kFloat32},
                                     {"z", 8, kFloat32},
                                     {"intensity", kVelodyneIntensity, kFloat32},
                                     {"ring", kVelodyneRing, kUint16},
                                     {"time", kVelodyneTime, kFloat32}};
constexpr std::uint32_t kVelodyneStep = 22;

// Layout of Swiftlet for small files: packed.
constexpr std::uint32_t kSmallIntensity = 12;
constexpr Field kSmallFields[] = {
    {"x", 0, kFloat32}, {"y", 4, kFloat32}, {"z", 8, kFloat32}, {"intensity", kSmallIntensity, kFloat32}};
constexpr std::uint32_t kSmallStep = 16;

// [rows] Sizes of a scan by which PointsLayout::kAuto selects Livox (Mid-360) and Velodyne (Puck, HDL-32E).
constexpr int kLivoxRows = 4, kPuckRows = 16, kHdl32Rows = 32;
/// [-] Reflectivity byte of a white Lambertian target; brighter bytes mean retroreflectors. Ouster and Velodyne have
/// the same scale, as has the small layout; Livox has its own.
constexpr int kDiffuseMax = 100, kLivoxDiffuseMax = 150;
/// [decades] Reflectivity above that of a white Lambertian target at which the byte reaches its greatest value, 255.
constexpr float kRetroreflectorDecades = 3.0F;
constexpr float kMmPerM = 1000.0F;

template <class Number>
void store(std::byte* at, Number value) {
  std::memcpy(at, &value, sizeof value);
}

void store_xyz(std::byte* at, const Scan& scan, int i, float step_m) {
  if (!scan.hit(i)) return;  // the drivers write zeros for a beam without return; the memory is already zero
  Eigen::Vector3f point = scan.point_lidar(i);
  if (step_m > 0.0F) point = (point / step_m).array().round() * step_m;
  std::memcpy(at, point.data(), 3 * sizeof(float));
}

/// Time of a beam since the start of the sweep.
std::uint32_t offset_ns(const Scan& scan, int i) { return static_cast<std::uint32_t>(scan.time_of(i) - scan.stamp); }

/// Row indices of a column in firing order.
std::vector<int> firing_order(const BeamTable& beams) {
  std::vector<int> rows(static_cast<std::size_t>(beams.rows));
  std::iota(rows.begin(), rows.end(), 0);
  if (!beams.row_offset_s.empty()) {
    std::stable_sort(rows.begin(), rows.end(),
                     [&](int a, int b) { return beams.row_offset_s[a] < beams.row_offset_s[b]; });
  }
  return rows;
}

/// Writes all fields of PointCloud2 that precede its data.
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
    out.put(std::uint32_t{1});  // count: numbers per field
  }
  out.put(false);  // is_bigendian
  out.put(step);
  out.put(step * static_cast<std::uint32_t>(width));
}

/// Organized cloud, one row per ring. Beams without return have zeros.
void encode_ouster(const Scan& scan, float step_m, std::uint32_t sequence, const std::string& frame, RosEncoder& out) {
  encode_description(sequence, scan, frame, scan.cols(), scan.rows(), kOusterFields, kOusterStep, out);
  std::byte* at = out.blob(static_cast<std::size_t>(scan.size()) * kOusterStep);
  for (int i = 0; i < scan.size(); ++i, at += kOusterStep) {
    store_xyz(at, scan, i, step_m);
    store(at + kOusterTime, offset_ns(scan, i));
    store(at + kOusterRing, static_cast<std::uint16_t>(i / scan.cols()));
    if (!scan.hit(i)) continue;
    store(at + kOusterIntensity, scan.intensity[i]);
    store(at + kOusterReflectivity, static_cast<std::uint16_t>(reflectivity_byte(scan.reflectivity[i], kDiffuseMax)));
    store(at + kOusterRange, static_cast<std::uint32_t>(std::lround(scan.range_from_axis_m(i) * kMmPerM)));
  }
}

/// Unorganized cloud in firing order. Beams without return have zeros.
void encode_livox(const Scan& scan, float step_m, std::uint32_t sequence, const std::string& frame, RosEncoder& out) {
  encode_description(sequence, scan, frame, scan.size(), 1, kLivoxFields, kLivoxStep, out);
  std::byte* at = out.blob(static_cast<std::size_t>(scan.size()) * kLivoxStep);
  const std::vector<int> rows = firing_order(*scan.beams);
  for (int column = 0; column < scan.cols(); ++column) {
    for (const int row : rows) {
      const int i = row * scan.cols() + column;
      store_xyz(at, scan, i, step_m);
      if (scan.hit(i)) {
        store(at + kLivoxIntensity, static_cast<float>(reflectivity_byte(scan.reflectivity[i], kLivoxDiffuseMax)));
      }
      store(at + kLivoxLine, static_cast<std::uint8_t>(row));
      store(at + kLivoxTimestamp, static_cast<double>(out.recorded(scan.time_of(i))));
      at += kLivoxStep;
    }
  }
}

/// Unorganized cloud in firing order, without beams that have no return.
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
      store(at + kVelodyneIntensity, static_cast<float>(reflectivity_byte(scan.reflectivity[i], kDiffuseMax)));
      const int ring = scan.rows() - 1 - row;  // the driver counts rings from the lowest beam up
      store(at + kVelodyneRing, static_cast<std::uint16_t>(ring));
      store(at + kVelodyneTime, static_cast<float>(to_seconds(scan.time_of(i) - scan.stamp)));
      at += kVelodyneStep;
    }
  }
}

/// Unorganized cloud in the order of the scan, row by row, without beams that have no return.
void encode_small(const Scan& scan, float step_m, std::uint32_t sequence, const std::string& frame, RosEncoder& out) {
  int num_points = 0;
  for (int i = 0; i < scan.size(); ++i) num_points += scan.hit(i) ? 1 : 0;
  encode_description(sequence, scan, frame, num_points, 1, kSmallFields, kSmallStep, out);
  std::byte* at = out.blob(static_cast<std::size_t>(num_points) * kSmallStep);
  for (int i = 0; i < scan.size(); ++i) {
    if (!scan.hit(i)) continue;
    store_xyz(at, scan, i, step_m);
    store(at + kSmallIntensity, static_cast<float>(reflectivity_byte(scan.reflectivity[i], kDiffuseMax)));
    at += kSmallStep;
  }
}

PointsLayout layout_for(PointsLayout layout, const Scan& scan) {
  if (layout != PointsLayout::kAuto) return layout;
  if (scan.rows() == kLivoxRows) return PointsLayout::kLivox;
  return scan.rows() == kPuckRows || scan.rows() == kHdl32Rows ? PointsLayout::kVelodyne : PointsLayout::kOuster;
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
  out.put(true);  // is_dense: no coordinate is NaN
}

std::uint8_t reflectivity_byte(float reflectivity, int diffuse_max) {
  const float diffuse = static_cast<float>(diffuse_max);
  if (!(reflectivity > 0.0F)) return 0;
  if (reflectivity <= 1.0F) return static_cast<std::uint8_t>(std::lround(diffuse * reflectivity));
  const float share = std::min(std::log10(reflectivity) / kRetroreflectorDecades, 1.0F);
  return static_cast<std::uint8_t>(std::lround(diffuse + (255.0F - diffuse) * share));
}

}  // namespace swiftlet::sim
