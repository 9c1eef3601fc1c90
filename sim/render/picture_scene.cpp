// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/picture_scene.hpp"

#include <algorithm>

#include "swiftlet/sim/world/labeled_scan.hpp"

namespace swiftlet::sim {
namespace {

// [m] Displacement after which a position is added to a trail. Larger values make curves angular.
constexpr float kTrailStep_m = 0.05F;
// [-] Number of positions at which the older half of a trail is thinned. Smaller values make old curves angular.
constexpr std::size_t kTrailMaxPoints = 8192;

}  // namespace

bool is_chosen(const Overlay& overlay, const std::vector<std::string>& names) {
  const std::string plain = overlay.name.substr(overlay.name.find('/') + 1);
  return std::any_of(names.begin(), names.end(),
                     [&](const std::string& n) { return n == "*" || n == plain || n == overlay.name; });
}

PictureCloud cloud_of(const LabeledScan& labeled, VehicleId vehicle) {
  const Scan& scan = labeled.scan;
  const ScanTruth& truth = labeled.truth;
  PictureCloud cloud;
  cloud.vehicle = vehicle;
  if (truth.T_world_lidar.empty()) return cloud;
  const bool moving = truth.T_world_lidar.size() > 1;
  const bool has_class = truth.surface_class.size() == scan.range_m.size();
  const bool has_reflectivity = scan.reflectivity.size() == scan.range_m.size();
  for (int i = 0; i < scan.size(); ++i) {
    if (!scan.hit(i)) continue;
    const Pose& T_world_lidar = truth.T_world_lidar[moving ? static_cast<std::size_t>(i % scan.cols()) : 0];
    cloud.points_world_m.push_back((T_world_lidar * scan.point_lidar(i).cast<double>()).cast<float>());
    if (has_reflectivity) cloud.intensity.push_back(scan.reflectivity[i]);
    if (has_class) cloud.surface_class.push_back(truth.surface_class[i]);
  }
  return cloud;
}

void extend_trail(std::vector<Eigen::Vector3f>& trail_world_m, const Eigen::Vector3f& p_world_m) {
  if (!trail_world_m.empty() && (trail_world_m.back() - p_world_m).norm() < kTrailStep_m) return;
  trail_world_m.push_back(p_world_m);
  if (trail_world_m.size() < kTrailMaxPoints) return;
  // Keeps the newer half unchanged and every other point of the older half.
  std::size_t kept = 0;
  for (std::size_t i = 0; i < trail_world_m.size(); ++i) {
    if (i < trail_world_m.size() / 2 && i % 2 == 1) continue;
    trail_world_m[kept++] = trail_world_m[i];
  }
  trail_world_m.resize(kept);
}

}  // namespace swiftlet::sim
