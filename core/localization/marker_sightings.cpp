// SPDX-License-Identifier: BSD-3-Clause
#include "core/localization/marker_sightings.hpp"

#include <algorithm>

namespace swiftlet {
namespace {

/// [m] Standard deviation of the center of a sighting, per axis. Larger values weigh sightings less.
constexpr double kSigma_m = 0.05;
constexpr int kMinBright = 2;  // fewest bright returns of a body; a single one may be a glint
// [-] Iterations that center a body on its returns, because markers lie below and before the center. Fewer leave an
// offset toward the markers.
constexpr int kRecenterings = 2;

}  // namespace

void MarkerSightings::append(const LocalCloud& cloud, std::vector<Sighting>& found) {
  gather(cloud);
  for (Body& body : bodies_) {
    TimeNs t = cloud.stamp();
    bool seen = body.count >= kMinBright;
    for (int i = 0; i < kRecenterings && seen; ++i) seen = center_on_returns(cloud, body, t);
    if (seen) found.push_back({t, body.middle_local_m.cast<double>(), kSigma_m * kSigma_m * Matrix3::Identity()});
  }
}

/// Groups bright returns that are nearer to each other than the width of a vehicle.
void MarkerSightings::gather(const LocalCloud& cloud) {
  bodies_.clear();
  if (cloud.scan->reflectivity.empty()) return;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (cloud.reflectivity_of(i) < reflectivity_) continue;
    const Eigen::Vector3f& p_local_m = cloud.points_local_m[i];
    const auto near = std::ranges::find_if(bodies_, [&](const Body& body) {
      return (body.middle_local_m - p_local_m).squaredNorm() <= radius_m_ * radius_m_;
    });
    if (near != bodies_.end()) {
      ++near->count;
      near->middle_local_m += (p_local_m - near->middle_local_m) / static_cast<float>(near->count);
    } else if (bodies_.size() < kMaxBrightBodies) {
      bodies_.push_back({p_local_m, 1});
    }
  }
}

/// Centers a body on the box, along and across the line of sight, around all returns near it.
bool MarkerSightings::center_on_returns(const LocalCloud& cloud, Body& body, TimeNs& t) const {
  const Eigen::Vector3f middle_local_m = body.middle_local_m;
  const Eigen::Vector3f sensor_local_m = cloud.T_local_lidar.front().translation().cast<float>();
  const Eigen::Vector2f sight_m = (middle_local_m - sensor_local_m).head<2>();
  const Eigen::Vector2f ahead = sight_m.norm() > 0.0F ? sight_m.normalized() : Eigen::Vector2f::UnitX();
  Eigen::AlignedBox3f box;
  TimeNs first = cloud.end(), last = cloud.stamp();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f d_m = cloud.points_local_m[i] - middle_local_m;
    if (d_m.squaredNorm() > radius_m_ * radius_m_) continue;
    box.extend(
        Eigen::Vector3f(ahead.x() * d_m.x() + ahead.y() * d_m.y(), ahead.x() * d_m.y() - ahead.y() * d_m.x(), d_m.z()));
    first = std::min(first, cloud.time_of(i));
    last = std::max(last, cloud.time_of(i));
  }
  if (box.isEmpty()) return false;
  const Eigen::Vector3f off_m = box.center();
  body.middle_local_m += Eigen::Vector3f(ahead.x() * off_m.x() - ahead.y() * off_m.y(),
                                         ahead.y() * off_m.x() + ahead.x() * off_m.y(), off_m.z());
  t = first + (last - first) / 2;
  return true;
}

}  // namespace swiftlet
