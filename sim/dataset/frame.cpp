// SPDX-License-Identifier: BSD-3-Clause
#include "sim/dataset/frame.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <stdexcept>
#include <string>

namespace swiftlet::sim {
namespace {

constexpr int kLeastRows = 8;

template <class Number>
std::byte* store(std::byte* at, Number value) {
  std::memcpy(at, &value, sizeof value);
  return at + sizeof value;
}

std::uint16_t to_grey(float value, float per_unit) {
  return static_cast<std::uint16_t>(std::clamp(value * per_unit + 0.5F, 1.0F, 65535.0F));
}

/// Poses of the sensor by column relative to the start of the sweep.
std::vector<Eigen::Isometry3f> relative_poses(const ScanTruth& truth) {
  const Pose T_start_world = truth.T_world_lidar.front().inverse();
  std::vector<Eigen::Isometry3f> poses;
  for (const Pose& pose : truth.T_world_lidar) poses.push_back((T_start_world * pose).cast<float>());
  return poses;
}

}  // namespace

void encode_frame(const LabelledScan& labelled, const ContentConfig& content, Frame& frame) {
  const Scan& scan = labelled.scan;
  const ScanTruth& truth = labelled.truth;
  const int rows = scan.rows(), columns = scan.cols();
  if (rows > 65536 || columns > 65536) {
    throw std::runtime_error("sensor " + scan.sensor + ": a dataset holds scans of at most 65536 rows and columns");
  }
  const auto room = static_cast<std::size_t>(scan.size());
  frame.velodyne.clear();
  frame.labels.clear();
  frame.point_truth.clear();
  std::byte* point_at = frame.velodyne.grow(room * kPointBytes);
  std::byte* label_at = frame.labels.grow(room * kLabelBytes);
  std::byte* truth_at = frame.point_truth.grow(room * kPointTruthBytes);

  const std::vector<float>& remission = content.remission == "intensity" ? scan.intensity : scan.reflectivity;
  const std::vector<Eigen::Isometry3f> poses =
      content.deskew ? relative_poses(truth) : std::vector<Eigen::Isometry3f>();
  int num_points = 0;
  for (int row = 0, i = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column, ++i) {
      if (!scan.hit(i)) continue;
      ++num_points;
      Eigen::Vector3f point = scan.point_lidar(i);
      if (!poses.empty()) point = poses[poses.size() == 1 ? 0 : static_cast<std::size_t>(column)] * point;
      point_at = store(store(store(store(point_at, point.x()), point.y()), point.z()), remission[i]);
      label_at = store(store(label_at, truth.surface_class[i]), truth.instance[i]);
      truth_at = store(truth_at, static_cast<std::uint32_t>(scan.time_of(i) - scan.stamp));
      truth_at = store(store(truth_at, static_cast<std::uint16_t>(row)), static_cast<std::uint16_t>(column));
      truth_at = store(store(truth_at, truth.range_m[i]), truth.incidence_rad[i]);
    }
  }
  frame.num_points = num_points;
  const auto count = static_cast<std::size_t>(num_points);
  frame.velodyne.shrink_to(count * kPointBytes);
  frame.labels.shrink_to(count * kLabelBytes);
  frame.point_truth.shrink_to(count * kPointTruthBytes);
}

void encode_images(const LabelledScan& labelled, const ContentConfig& content, std::vector<std::uint16_t>& range,
                   std::vector<std::uint16_t>& intensity) {
  const Scan& scan = labelled.scan;
  range.assign(static_cast<std::size_t>(scan.size()), 0);
  intensity.assign(static_cast<std::size_t>(scan.size()), 0);
  const auto per_range_unit = static_cast<float>(1.0 / content.range_unit_m);
  const auto per_intensity_unit = static_cast<float>(1.0 / content.intensity_unit);
  for (int i = 0; i < scan.size(); ++i) {
    if (!scan.hit(i)) continue;
    range[static_cast<std::size_t>(i)] = to_grey(scan.range_m[i], per_range_unit);
    intensity[static_cast<std::size_t>(i)] = to_grey(scan.intensity[i], per_intensity_unit);
  }
}

bool makes_an_image(const Scan& scan) { return scan.rows() >= kLeastRows && scan.cols() >= kLeastRows; }

std::vector<int> pixel_shift_by_row(const BeamTable& beams) {
  std::vector<int> shifts(static_cast<std::size_t>(beams.rows), 0);
  if (beams.cols < 2) return shifts;
  const auto azimuth = [&](int row, int column) {
    const Eigen::Vector3f& d = beams.directions_lidar[static_cast<std::size_t>(row) * beams.cols + column];
    return std::atan2(static_cast<double>(d.y()), static_cast<double>(d.x()));
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
