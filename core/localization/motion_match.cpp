// SPDX-License-Identifier: BSD-3-Clause
#include "core/localization/motion_match.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/core/localization/relative_alignment.hpp"

namespace swiftlet {
namespace {

/// [ns] Least time between sightings of a chain. Smaller values store more, with correlated errors.
constexpr TimeNs kSpacing = kNsPerSecond / 5;
constexpr std::size_t kMaxSightings = 64;  // largest number of sightings of a chain: 13 s
constexpr double kReach_m = 0.5;           // largest step between successive sightings of a chain at zero interval
constexpr double kReach_mps = 2.0;         // growth of that step with the interval

}  // namespace

MotionMatch match_motion(std::span<const Sighting> seen, const RelativeOdometry& reported, const OdometryDrift& drift,
                         double clock_s, double gap_max_s) {
  std::vector<Vector3> local_m, other_m;
  std::vector<double> weights;
  local_m.reserve(seen.size());
  other_m.reserve(seen.size());
  weights.reserve(seen.size());
  if (reported.empty()) return {};
  for (const Sighting& sighting : seen) {
    const auto motion = reported.at(sighting.t - from_seconds(clock_s), gap_max_s);
    if (!motion) continue;
    const double drifted_m2 = drift.position_variance_m2(reported.newest().flown - motion->flown);
    local_m.push_back(sighting.p_local_m);
    other_m.push_back(motion->p_other_local_m);
    weights.push_back(1.0 / (sighting.covariance.trace() / 3.0 + drifted_m2));
  }
  MotionMatch match;
  match.count = static_cast<int>(weights.size());
  if (weights.empty()) return match;

  Vector3 mean_m = Vector3::Zero();
  for (const Vector3& p_m : local_m) mean_m += p_m / static_cast<double>(match.count);
  // Odometry at rest gives no heading: then all observed motion is residual.
  const auto aligned = align_in_closed_form(local_m, other_m, weights);
  double spread_m2 = 0.0, residual = 0.0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    spread_m2 += (local_m[i] - mean_m).head<2>().squaredNorm();
    residual += weights[i] * (local_m[i] - (aligned ? aligned->point(other_m[i]) : mean_m)).squaredNorm();
  }
  match.spread_m = std::sqrt(spread_m2 / match.count);
  match.residual_sigma = std::sqrt(residual / (3.0 * match.count));
  return match;
}

void SightingChains::push(const Sighting& sighting) {
  Chain* nearest = nullptr;
  double least_m = 0.0;
  for (Chain& chain : chains_) {
    const double distance_m = (chain.newest.p_local_m - sighting.p_local_m).norm();
    const double reach_m = kReach_m + kReach_mps * std::abs(to_seconds(sighting.t - chain.newest.t));
    if (distance_m > reach_m || (nearest != nullptr && distance_m >= least_m)) continue;
    nearest = &chain;
    least_m = distance_m;
  }
  if (nearest == nullptr) {
    if (chains_.size() == kMaxBrightBodies) return;
    nearest = &chains_.emplace_back();
  }
  nearest->newest = sighting;
  std::vector<Sighting>& kept = nearest->sightings;
  if (!kept.empty() && sighting.t - kept.back().t < kSpacing) return;
  if (kept.size() == kMaxSightings) kept.erase(kept.begin());
  kept.push_back(sighting);
}

void SightingChains::forget_before(TimeNs t) {
  std::erase_if(chains_, [t](const Chain& chain) { return chain.newest.t < t; });
}

}  // namespace swiftlet
