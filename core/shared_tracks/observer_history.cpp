// SPDX-License-Identifier: BSD-3-Clause
#include "core/shared_tracks/observer_history.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace swiftlet {
namespace {

double turned_rad(double from_rad, double to_rad) { return std::remainder(to_rad - from_rad, 2.0 * std::numbers::pi); }

}  // namespace

bool SampledPath::push(const PathSample& sample) {
  if (!samples_.empty() && sample.t <= samples_.back().t) return false;
  if (samples_.size() == kCapacity) samples_.erase(samples_.begin());
  samples_.push_back(sample);
  return true;
}

void SampledPath::forget_before(TimeNs t) {
  const auto kept = std::find_if(samples_.begin(), samples_.end(), [t](const PathSample& s) { return s.t >= t; });
  samples_.erase(samples_.begin(), kept);
}

std::optional<PathSample> SampledPath::at(TimeNs t, double gap_max_s) const {
  const auto after = std::lower_bound(samples_.begin(), samples_.end(), t,
                                      [](const PathSample& s, TimeNs time) { return s.t < time; });
  if (after == samples_.end()) return std::nullopt;
  if (after->t == t) return *after;
  if (after == samples_.begin()) return std::nullopt;
  const PathSample &a = *(after - 1), &b = *after;
  const double gap_s = to_seconds(b.t - a.t);
  if (gap_s > gap_max_s) return std::nullopt;
  const double x = to_seconds(t - a.t) / gap_s;
  PathSample out;
  out.t = t;
  const double x2 = x * x, x3 = x2 * x;  // Hermite's cubic
  out.p_local_m = (2.0 * x3 - 3.0 * x2 + 1.0) * a.p_local_m + (3.0 * x2 - 2.0 * x3) * b.p_local_m +
                  gap_s * ((x3 - 2.0 * x2 + x) * a.v_local_mps + (x3 - x2) * b.v_local_mps);
  out.v_local_mps = (1.0 - x) * a.v_local_mps + x * b.v_local_mps;
  out.covariance = (1.0 - x) * a.covariance + x * b.covariance;
  out.yaw_rad = a.yaw_rad + x * turned_rad(a.yaw_rad, b.yaw_rad);
  out.flown.path_m = a.flown.path_m + x * (b.flown.path_m - a.flown.path_m);
  out.flown.turn_rad = a.flown.turn_rad + x * (b.flown.turn_rad - a.flown.turn_rad);
  out.flown.time_s = a.flown.time_s + x * (b.flown.time_s - a.flown.time_s);
  return out;
}

bool ObserverHistory::push_self(TimeNs t, const Vector3& p_local_m, const Vector3& v_local_mps, double yaw_rad,
                                double sigma_m) {
  PathSample sample{t, p_local_m, v_local_mps, sigma_m * sigma_m * Matrix3::Identity(), yaw_rad, flown_};
  if (!self_.empty()) {
    const PathSample& last = self_.newest();
    if (t <= last.t) return false;
    sample.flown.path_m += (p_local_m - last.p_local_m).norm();
    sample.flown.turn_rad += std::abs(turned_rad(last.yaw_rad, yaw_rad));
    sample.flown.time_s += to_seconds(t - last.t);
  }
  flown_ = sample.flown;
  return self_.push(sample);
}

void ObserverHistory::push_track(std::uint32_t identity, TimeNs t, const Vector3& p_local_m, const Vector3& v_local_mps,
                                 const Matrix3& covariance) {
  auto seen = std::lower_bound(seen_.begin(), seen_.end(), identity,
                               [](const Seen& s, std::uint32_t id) { return s.identity < id; });
  if (seen == seen_.end() || seen->identity != identity) seen = seen_.insert(seen, {identity, {}});
  seen->path.push({t, p_local_m, v_local_mps, covariance, 0.0, flown_});
}

void ObserverHistory::forget_before(TimeNs t) {
  self_.forget_before(t);
  for (Seen& seen : seen_) seen.path.forget_before(t);
  std::erase_if(seen_, [](const Seen& seen) { return seen.path.empty(); });
}

void ObserverHistory::clear() { *this = {}; }

}  // namespace swiftlet
