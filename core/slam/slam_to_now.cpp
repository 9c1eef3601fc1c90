// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/slam_to_now.hpp"

#include <utility>

namespace swiftlet {
namespace {

// Interval that the last IMU sample bridges up to the end of a scan. Longer ones wait for further samples while the
// latency of the scan allows it.
constexpr TimeNs kBridged = 5'000'000;

}  // namespace

SlamToNow::SlamToNow(const LocalSlamConfig& config, double latency_s, const Pose& T_local_body_start,
                     double own_radius_m, std::unique_ptr<ScanMatcher> matcher)
    : latency_(latency_s),
      slam_(config, T_local_body_start, own_radius_m, std::move(matcher)),
      now_(slam_.filter()),
      ring_(latency_s > 0.0 ? kMaxSamples : 0) {}

void SlamToNow::add(const ImuSample& sample) {
  if (waiting_.empty() || ring_.empty()) {
    slam_.add(sample);
    num_added_ = ++num_samples_;
    return;
  }
  if (num_ahead() == kMaxSamples) add_until(num_added_ + 1);
  if (num_ahead() == 0) now_ = slam_.filter();
  ring_[num_samples_++ % kMaxSamples] = sample;
  now_.predict(sample);
}

void SlamToNow::add(TimeNs t, std::shared_ptr<const Scan> scan, std::span<const SeenVehicle> others) {
  waiting_.push_back({t, std::move(scan), num_samples_, {others.begin(), others.end()}});
}

std::optional<SlamToNow::Matched> SlamToNow::match_next(TimeNs t) {
  if (!is_due(t)) return std::nullopt;
  Arrival arrival = std::move(waiting_.front());
  waiting_.erase(waiting_.begin());
  add_until(arrival.samples_before);
  const TimeNs end = slam_.imu_time_of_end(*arrival.scan);
  while (num_ahead() > 0 && slam_.filter().state().nav.t < end - kBridged) add_until(num_added_ + 1);
  Matched matched{arrival.t, slam_.add(std::move(arrival.scan), std::move(arrival.others))};
  if (!is_due(t)) catch_up();
  return matched;
}

void SlamToNow::add_until(std::uint64_t num_samples) {
  for (; num_added_ < num_samples; ++num_added_) slam_.add(sample(num_added_));
}

/// Local SLAM processes samples up to the next scan; a copy of its filter predicts from there to now.
void SlamToNow::catch_up() {
  add_until(waiting_.empty() ? num_samples_ : waiting_.front().samples_before);
  if (num_ahead() == 0) return;
  now_ = slam_.filter();
  for (std::uint64_t i = num_added_; i < num_samples_; ++i) now_.predict(sample(i));
}

}  // namespace swiftlet
