// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/graph/gnss_factors.hpp"

#include <algorithm>
#include <iterator>

#include "core/slam/level_pose.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/core/localization/frame_change.hpp"

namespace swiftlet {
namespace {

// Longest delay between a scan and a GNSS fix that arrives before it [s]. Scans that are later may lose their fix.
constexpr double kScanLate_s = 2.0;
// [-] Largest number of pairs of position and GNSS fix kept to fit an unknown start; beyond it the oldest is dropped.
// Larger values average more fixes.
constexpr std::size_t kMaxMatched = 2000;
// [-] Fewest pairs to fit an unknown start. Larger values fit it later.
constexpr std::size_t kMinMatched = 5;
// [m] Extent of the path from which an unknown start is fitted to GNSS. Larger values fit it later, with a smaller
// error of the heading.
constexpr double kFitSpread_m = 5.0;

}  // namespace

Vector3 gnss_weight_1_m(const GnssFactorConfig& config, const Vector3& sigma_world_m) {
  // [m] Lower bound of the reported sigmas, as in the released code. Smaller values let one fix outweigh all else.
  constexpr double kLeast_m = 0.003;
  Vector3 sigma_m = sigma_world_m.cwiseMax(kLeast_m);
  if (config.weighting == GnssWeighting::kIsotropic) sigma_m.setConstant(sigma_m.maxCoeff());
  const Vector3 inverse_1_m = config.weighting == GnssWeighting::kReleased ? Vector3(sigma_m.cwiseAbs2().cwiseInverse())
                                                                           : Vector3(sigma_m.cwiseInverse());
  return config.a * inverse_1_m + Vector3::Constant(config.b_1_m);
}

Pose fit_to_world(std::span<const MatchedPosition> points, double yaw_rad, double least_spread_m) {
  double weight = 0.0;
  Vector3 mean_local_m = Vector3::Zero(), mean_world_m = Vector3::Zero();
  for (const MatchedPosition& m : points) {
    weight += m.weight;
    mean_local_m += m.weight * m.p_local_m;
    mean_world_m += m.weight * m.p_world_m;
  }
  ENSURE(weight > 0.0, points.size());
  mean_local_m /= weight;
  mean_world_m /= weight;
  double along = 0.0, across = 0.0, spread_m2 = 0.0;
  for (const MatchedPosition& m : points) {
    const Vector3 l = m.p_local_m - mean_local_m, w = m.p_world_m - mean_world_m;
    along += m.weight * (l.x() * w.x() + l.y() * w.y());
    across += m.weight * (l.x() * w.y() - l.y() * w.x());
    spread_m2 += m.weight * l.head<2>().squaredNorm();
  }
  const bool is_significant = spread_m2 >= weight * least_spread_m * least_spread_m;
  return level_alignment(is_significant ? elementary::atan2(across, along) : yaw_rad, mean_world_m, mean_local_m);
}

void GnssFactors::add(const GnssSample& sample, const TrajectoryGraph& trajectory) {
  if (!config_.use_gnss || !sample.p_world_m.allFinite() || !sample.sigma_p_m.allFinite()) return;
  if (trajectory.nodes().empty() || sample.t < trajectory.nodes().back().t) return;
  waiting_.push_back(sample);
  // The next node uses the newest fix that is not newer than the node.
  while (waiting_.size() > 1 && to_seconds(sample.t - waiting_[1].t) > kScanLate_s) waiting_.erase(waiting_.begin());
}

bool GnssFactors::place(TrajectoryGraph& trajectory) {
  const std::vector<TrajectoryNode>& nodes = trajectory.nodes();
  if (waiting_.empty() || nodes.size() < 2) return false;
  const TrajectoryNode &before = nodes[nodes.size() - 2], &after = nodes.back();
  const auto newer =
      std::find_if(waiting_.begin(), waiting_.end(), [&](const GnssSample& fix) { return fix.t > after.t; });
  if (newer == waiting_.begin()) return false;
  const GnssSample fix = *std::prev(newer);
  waiting_.erase(waiting_.begin(), newer);
  const double beta = std::max(0.0, to_seconds(fix.t - before.t) / to_seconds(after.t - before.t));
  trajectory.add(PositionFactor{before.pose, after.pose, beta, fix.p_world_m,
                                gnss_weight_1_m(config_.gnss, fix.sigma_p_m), config_.gnss.huber});
  const Vector3 p_local_m = (1.0 - beta) * before.T_local_body.translation() + beta * after.T_local_body.translation();
  if (fits_start_) matched_.push_back({p_local_m, fix.p_world_m, 1.0});
  if (matched_.size() > kMaxMatched) matched_.erase(matched_.begin());
  return true;
}

void GnssFactors::fit_start(TrajectoryGraph& trajectory) {
  if (!fits_start_ || matched_.size() < kMinMatched) return;
  const TrajectoryNode& first = trajectory.nodes().front();
  const Pose T_world_local = level_pose(trajectory.graph().pose(first.pose) * first.T_local_body.inverse());
  const double yaw_rad = yaw_of(T_world_local.linear());
  const Pose fitted = fit_to_world(matched_, yaw_rad, kFitSpread_m);
  if (yaw_of(fitted.linear()) == yaw_of(level_alignment(yaw_rad, Vector3::Zero(), Vector3::Zero()).linear()))
    return;  // fixes too near to each other
  fits_start_ = false;
  matched_ = {};
  trajectory.move_flight(fitted * T_world_local.inverse());
  trajectory.add_start_guess();
}

}  // namespace swiftlet
