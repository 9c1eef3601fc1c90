// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/learned_air.hpp"

#include <algorithm>
#include <cmath>

#include "core/detection/direction_bins.hpp"

namespace swiftlet {
namespace {

using Limits = TrackBeforeDetectLimits;

/// [m] Length up to which a beam without return clears air. Larger values clear air where dark objects return nothing.
constexpr double kEmptyRay_m = 40.0;
/// [m] Radius around a new hypothesis in which hardly any beam may have ended so far, so that it lies in free air;
/// extended by the noise of the attitude. Larger values begin no hypotheses near the background.
constexpr double kFreeReach_m = 1.0;

}  // namespace

LearnedAir::LearnedAir(const TrackBeforeDetectConfig& config)
    : background_share_(config.background_share),
      free_share_(config.free_share),
      hit_share_(config.hit_share),
      learning_delay_(from_seconds(config.learning_delay_s)),
      rays_per_sweep_(config.rays_per_sweep),
      map_(config.air),
      pending_(Limits::kMaxPending) {}

void LearnedAir::begin_sweep(const LocalCloud& cloud, std::span<const Eigen::Vector3f> empty_lidar,
                             const BeamIndex& beams) {
  const int num_beams = cloud.scan->size() + static_cast<int>(empty_lidar.size());
  ray_stride_ = std::max(1, (num_beams + rays_per_sweep_ - 1) / rays_per_sweep_);
  map_.follow(beams.p_local_lidar_m());
}

bool LearnedAir::is_free(const Vector3& p_local_m, double blur_m) const {
  const auto reach = [&](double reach_m) {
    return static_cast<int>(std::min(std::ceil(reach_m / map_.voxel_m()), Limits::kMaxVoxels));
  };
  const int near = std::max(1, reach(blur_m)), far = reach(kFreeReach_m + blur_m);
  return map_.is_free_around(p_local_m, near, free_share_) &&
         !map_.is_hit_around(p_local_m, std::max(near, far), hit_share_);
}

void LearnedAir::queue_for_background(TimeNs t, const Eigen::Vector3f& p_local_m, std::uint32_t hypothesis,
                                      std::span<const Hypothesis> all) {
  if (num_pending_ == Limits::kMaxPending) learn_oldest(all);
  pending_[(first_pending_ + num_pending_++) % Limits::kMaxPending] = {t, p_local_m, hypothesis};
}

void LearnedAir::learn(TimeNs t, std::span<const Hypothesis> all) {
  const TimeNs before = t - learning_delay_;
  while (num_pending_ > 0 && pending_[first_pending_].t <= before) learn_oldest(all);
}

void LearnedAir::learn_oldest(std::span<const Hypothesis> all) {
  const Pending& p = pending_[first_pending_];
  const auto h =
      std::find_if(all.begin(), all.end(), [&](const Hypothesis& other) { return other.id == p.hypothesis; });
  hit(p.p_local_m.cast<double>(), h == all.end() ? 1.0 : 1.0 - h->existence);
  first_pending_ = (first_pending_ + 1) % Limits::kMaxPending;
  --num_pending_;
}

void LearnedAir::clear(const LocalCloud& cloud, std::span<const Eigen::Vector3f> empty_lidar, const BeamIndex& beams) {
  const Scan& scan = *cloud.scan;
  const BeamTable& table = *scan.beams;
  ray_offset_ = (ray_offset_ + 1) % ray_stride_;
  int i = ray_offset_;
  for (; i < scan.size(); i += ray_stride_) {
    const auto at = static_cast<std::size_t>(i);
    if ((!table.masked.empty() && table.masked[at]) || !has_direction(table, i)) continue;
    const Pose& T = cloud.T_local_lidar_of_beam(i);
    clear_beam(T * table.origins_lidar[at].cast<double>(), T.linear() * table.directions_lidar[at].cast<double>(),
               scan.range_m[at], beams);
  }
  for (i -= scan.size(); i < static_cast<int>(empty_lidar.size()); i += ray_stride_) {
    clear_beam(beams.p_local_lidar_m(), beams.R_local_lidar() * empty_lidar[static_cast<std::size_t>(i)].cast<double>(),
               0.0, beams);
  }
}

// A ray ends one voxel before its return, for the noise of the pose; a ray without return ends before the nearest
// return around it.
void LearnedAir::clear_beam(const Vector3& from_local_m, const Vector3& direction_local, double range_m,
                            const BeamIndex& beams) {
  const double edge_m = map_.voxel_m();
  const double length_m = range_m > 0.0 ? std::min(range_m - edge_m, Limits::kMaxRange_m)
                                        : std::min(beams.nearest_return_m(direction_local) - edge_m, kEmptyRay_m);
  if (length_m > 0.0) map_.pass(from_local_m, from_local_m + length_m * direction_local);
}

}  // namespace swiftlet
