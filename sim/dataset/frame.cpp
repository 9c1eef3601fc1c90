// SPDX-License-Identifier: BSD-3-Clause
#include "sim/dataset/frame.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <stdexcept>
#include <string>

#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet::sim {
namespace {

// [-] Fewest rows and columns of a scan with images; patterns without rows have fewer.
constexpr int kMinRows = 8;

template <class Number>
std::byte* store(std::byte* at, Number value) {
  std::memcpy(at, &value, sizeof value);
  return at + sizeof value;
}

std::uint16_t to_gray(float value, float per_unit) {
  return static_cast<std::uint16_t>(std::clamp(value * per_unit + 0.5F, 1.0F, 65535.0F));
}

/// Poses of the sensor at each column relative to its pose at the start of the sweep.
std::vector<Eigen::Isometry3f> relative_poses(const ScanTruth& truth) {
  const Pose T_start_world = truth.T_world_lidar.front().inverse();
  std::vector<Eigen::Isometry3f> poses;
  for (const Pose& pose : truth.T_world_lidar) poses.push_back((T_start_world * pose).cast<float>());
  return poses;
}

/// Scan::time_of() minus the stamp; computed once per column where all rows of a column fire at once.
class FiringTimes {
 public:
  explicit FiringTimes(const Scan& scan)
      : beams_(*scan.beams), at_once_(scan.duration == 0), by_column_(beams_.row_offset_s.empty()) {
    if (at_once_ || !by_column_) return;
    for (int column = 0; column < beams_.cols; ++column) column_ns_.push_back(to_ns(beams_.column_offset_s[column]));
  }
  std::uint32_t offset_ns(int row, int column) const {
    if (at_once_) return 0;
    if (by_column_) return column_ns_[static_cast<std::size_t>(column)];
    return to_ns(static_cast<double>(beams_.column_offset_s[column]) + static_cast<double>(beams_.row_offset_s[row]));
  }

 private:
  static std::uint32_t to_ns(double offset_s) { return static_cast<std::uint32_t>(from_seconds(offset_s)); }

  const BeamTable& beams_;
  bool at_once_, by_column_;
  std::vector<std::uint32_t> column_ns_;
};

}  // namespace

void encode_frame(const LabeledScan& labeled, const ContentConfig& content, Frame& frame) {
  const Scan& scan = labeled.scan;
  const ScanTruth& truth = labeled.truth;
  const int rows = scan.rows(), columns = scan.cols();
  if (rows > 65536 || columns > 65536) {
    throw std::runtime_error("sensor " + scan.sensor + ": a dataset holds scans of at most 65536 rows and columns");
  }
  const auto room = static_cast<std::size_t>(scan.size());
  frame.velodyne.clear();
  frame.labels.clear();
  frame.point_truth.clear();
  std::byte* point_at = frame.velodyne.extend(room * kPointBytes);
  std::byte* label_at = frame.labels.extend(room * kLabelBytes);
  std::byte* truth_at = frame.point_truth.extend(room * kPointTruthBytes);
  const std::byte* const first_label = label_at;

  // The byte writes below may alias any object; local copies let the compiler keep these values in registers.
  const float* const range_m = scan.range_m.data();
  const float* const remission =
      (content.remission == ContentConfig::Remission::kIntensity ? scan.intensity : scan.reflectivity).data();
  const Eigen::Vector3f* const origin_m = scan.beams->origins_lidar.data();
  const Eigen::Vector3f* const direction = scan.beams->directions_lidar.data();
  const std::uint16_t* const surface_class = truth.surface_class.data();
  const std::uint16_t* const instance = truth.instance.data();
  const float* const true_range_m = truth.range_m.data();
  const float* const incidence_rad = truth.incidence_rad.data();
  const std::vector<Eigen::Isometry3f> poses =
      content.deskew ? relative_poses(truth) : std::vector<Eigen::Isometry3f>();
  const FiringTimes firing(scan);
  for (int row = 0, i = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column, ++i) {
      if (!(range_m[i] > 0.0F)) continue;
      Eigen::Vector3f point = origin_m[i] + range_m[i] * direction[i];
      if (!poses.empty()) point = poses[poses.size() == 1 ? 0 : static_cast<std::size_t>(column)] * point;
      point_at = store(store(store(store(point_at, point.x()), point.y()), point.z()), remission[i]);
      label_at = store(store(label_at, surface_class[i]), instance[i]);
      truth_at = store(truth_at, firing.offset_ns(row, column));
      truth_at = store(store(truth_at, static_cast<std::uint16_t>(row)), static_cast<std::uint16_t>(column));
      truth_at = store(store(truth_at, true_range_m[i]), incidence_rad[i]);
    }
  }
  const auto count = static_cast<std::size_t>(label_at - first_label) / kLabelBytes;
  frame.num_points = static_cast<int>(count);
  frame.velodyne.shrink_to(count * kPointBytes);
  frame.labels.shrink_to(count * kLabelBytes);
  frame.point_truth.shrink_to(count * kPointTruthBytes);
}

void encode_images(const LabeledScan& labeled, const ContentConfig& content, std::vector<std::uint16_t>& range,
                   std::vector<std::uint16_t>& intensity) {
  const Scan& scan = labeled.scan;
  range.assign(static_cast<std::size_t>(scan.size()), 0);
  intensity.assign(static_cast<std::size_t>(scan.size()), 0);
  const auto per_range_unit = static_cast<float>(1.0 / content.range_unit_m);
  const auto per_intensity_unit = static_cast<float>(1.0 / content.intensity_unit);
  for (int i = 0; i < scan.size(); ++i) {
    if (!scan.hit(i)) continue;
    range[static_cast<std::size_t>(i)] = to_gray(scan.range_from_axis_m(i), per_range_unit);
    intensity[static_cast<std::size_t>(i)] = to_gray(scan.intensity[i], per_intensity_unit);
  }
}

bool is_image_shaped(const Scan& scan) { return scan.rows() >= kMinRows && scan.cols() >= kMinRows; }

std::vector<int> pixel_shift_by_row(const BeamTable& beams) {
  std::vector<int> shifts(static_cast<std::size_t>(beams.rows), 0);
  if (beams.cols < 2) return shifts;
  const auto azimuth = [&](int row, int column) {
    const Eigen::Vector3f& d = beams.directions_lidar[static_cast<std::size_t>(row) * beams.cols + column];
    return elementary::atan2(static_cast<double>(d.y()), static_cast<double>(d.x()));
  };
  const auto wrapped = [](double angle) { return std::remainder(angle, 2.0 * std::numbers::pi); };
  const double pitch = wrapped(azimuth(0, 1) - azimuth(0, 0));
  if (std::abs(pitch) < 1e-9) return shifts;
  for (int row = 0; row < beams.rows; ++row) {
    shifts[static_cast<std::size_t>(row)] =
        static_cast<int>(std::lround(wrapped(azimuth(row, 0) - azimuth(0, 0)) / pitch));
  }
  return shifts;
}

}  // namespace swiftlet::sim
