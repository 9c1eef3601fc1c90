// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/body_parts.hpp"

#include "core/detection/existence.hpp"
#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet {
namespace {

// [sweeps] Time without returns of both targets after which a pair is dropped. Smaller values forget bodies in
// occlusions.
constexpr int kMaxSilentSweeps = 50;

Vector3 mean_of(std::span<const Vector3> points_m) {
  Vector3 sum_m = Vector3::Zero();
  for (const Vector3& p_m : points_m) sum_m += p_m;
  return sum_m / static_cast<double>(points_m.size());
}

}  // namespace

void BodyParts::begin_sweep() {
  for (Pair& pair : pairs_) ++pair.silent_sweeps;
  std::erase_if(pairs_, [](const Pair& pair) { return pair.silent_sweeps > kMaxSilentSweeps; });
}

// The means are compared with returns of the same sweep, so pose noise cancels.
bool BodyParts::weigh(std::uint32_t id_a, std::span<const Vector3> a_local_m, std::uint32_t id_b,
                      std::span<const Vector3> b_local_m) {
  auto pair = std::find_if(pairs_.begin(), pairs_.end(), [&](const Pair& other) { return other.is_of(id_a, id_b); });
  if (pair == pairs_.end()) {
    if (pairs_.size() == kMaxPairs) return false;
    pair = pairs_.insert(pairs_.end(), {std::min(id_a, id_b), std::max(id_a, id_b)});
  }
  pair->silent_sweeps = 0;
  if (a_local_m.size() + b_local_m.size() < 3) return false;  // single returns: none lies between their means
  const Vector3 from_m = mean_of(a_local_m), axis_m = mean_of(b_local_m) - from_m;
  const double in_middle = elementary::log(kMiddleOfOne / kMiddleOfTwo);
  const double beside = elementary::log((1.0 - kMiddleOfOne) / (1.0 - kMiddleOfTwo));
  const auto count = [&](std::span<const Vector3> points_m) {
    for (const Vector3& p_m : points_m) {
      const double third = 3.0 * (p_m - from_m).dot(axis_m) / axis_m.squaredNorm();  // NaN, beside, for equal means
      pair->log_odds += third > 1.0 && third < 2.0 ? in_middle : beside;
    }
  };
  count(a_local_m);
  count(b_local_m);
  pair->log_odds = std::clamp(pair->log_odds, -kMaxLogOdds, kMaxLogOdds);
  return pair->log_odds > kDecided;
}

void BodyParts::forget(std::uint32_t id) {
  std::erase_if(pairs_, [&](const Pair& pair) { return pair.low == id || pair.high == id; });
}

double BodyParts::log_odds(std::uint32_t id_a, std::uint32_t id_b) const {
  const auto pair =
      std::find_if(pairs_.begin(), pairs_.end(), [&](const Pair& other) { return other.is_of(id_a, id_b); });
  return pair != pairs_.end() ? pair->log_odds : 0.0;
}

}  // namespace swiftlet
