// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/separation/neighbor_memory.hpp"

#include <Eigen/LU>
#include <algorithm>

#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/core/messages/neighbor_position.hpp"

namespace swiftlet {
namespace {

/// [m^2] Variance of positions received by radio, per axis. Larger values smooth the estimated velocities and delay
/// them.
constexpr double kRadioVariance_m2 = 1e-4;
/// [ns] Longest prediction. After that the position is held, and its uncertainty grows with kUnseenGrowth_mps. Larger
/// values trust old velocities.
constexpr TimeNs kLongestAhead = 1'000'000'000;
/// [m/s] Growth of the standard deviation of a held position. Larger values keep more distance from unmeasured
/// neighbors.
constexpr double kUnseenGrowth_mps = 0.5;
/// [ns] Time after kLongestAhead until an unmeasured neighbor counts as at rest. Larger values brake for lost
/// neighbors.
constexpr TimeNs kLongestMotion = 2'000'000'000;
/// [s] Time constant with which the longest sample interval decays. Larger values keep the team slow after a dropout.
constexpr double kFade_s = 20.0;
/// [s] Longest gap between two samples that counts as an interval; after a longer one, the neighbor counts as lost.
/// Larger values slow the team down after a dropout.
constexpr double kLongestInterval_s = 4.0;

}  // namespace

NeighborSourceConfig NeighborSourceConfig::without_memory() {
  NeighborSourceConfig config;
  config.timeout_s = config.acceleration_sigma_mps2 = config.first_speed_sigma_mps = 1.0;
  config.remember_hidden = false;
  return config;
}

void NeighborSourceConfig::visit(ConfigVisitor& v) {
  v.choice("source", source, {"sensor", "radio", "tracks", "none"},
           "[-] neighbors from a `neighbors` sensor (ideal: the truth), from their messages, or from the own tracks");
  v.field("timeout_s", timeout_s,
          "[s] time without a measurement in the sensor's view after which a neighbor is dropped", Range::positive());
  v.field("acceleration_sigma_mps2", acceleration_sigma_mps2,
          "[m/s^2] standard deviation of a neighbor's acceleration (process noise of its filter)", Range::positive());
  v.field("first_speed_sigma_mps", first_speed_sigma_mps,
          "[m/s] standard deviation per axis of the velocity of a neighbor after its first measurement",
          Range::positive());
  v.field(
      "remember_hidden", remember_hidden,
      "[-] whether the timeout counts only while the neighbor should be in view: a neighbor in the blind sector is not "
      "forgotten");
}

void NeighborMemory::update(const GuidanceInput& input) {
  const TimeNs now = input.observation.t;
  now_ = now;
  if (config_.source == NeighborSourceConfig::Source::kSensor) {
    for (const NeighborSample& sample : input.observation.neighbors) {
      const Pose T_local_body = input.poses.at(sample.t);
      const Matrix3& R = T_local_body.linear();
      measure(sample.id, sample.t, T_local_body * sample.p_body_m, R * sample.covariance_body * R.transpose(),
              T_local_body.translation());
    }
  } else if (config_.source == NeighborSourceConfig::Source::kRadio) {
    for (const Message& message : input.observation.messages) receive(message, input);
  }
  if (config_.source == NeighborSourceConfig::Source::kTracks) {
    known_.clear();
    for (const Track& track : input.tracks) {
      const double ahead_s = to_seconds(now - track.t);
      known_.push_back({track.id, track.position_m + ahead_s * track.velocity_mps, track.velocity_mps, track.t,
                        track.covariance.topLeftCorner<3, 3>(), track.covariance.block<3, 3>(3, 3)});
      known_.back().seen_local_m = track.position_m;
      known_.back().seen_covariance_local_m2 = track.covariance.topLeftCorner<3, 3>();
      known_.back().own_seen_local_m = input.poses.at(track.t).translation();
    }
    std::sort(known_.begin(), known_.end(), [](const Neighbor& a, const Neighbor& b) { return a.key < b.key; });
    return;
  }
  const Pose T_body_local = input.estimate.T_local_body.inverse();
  for (Filter& filter : filters_) {
    const Vector3 p_body_m = T_body_local * position_now_local_m(filter);
    filter.in_view = is_any(&NeighborView::contains, p_body_m);
    filter.looked_at = is_any(&NeighborView::looks_at, p_body_m);
  }
  forget(now);
  to_carry_ = true;
}

std::span<const Neighbor> NeighborMemory::neighbors() {
  if (to_carry_) {
    known_.clear();
    for (const Filter& filter : filters_) known_.push_back(now_of(filter));
    to_carry_ = false;
  }
  return known_;
}

Vector3 NeighborMemory::position_now_local_m(const Filter& filter) const {
  const TimeNs ahead = std::min(now_, filter.t + kLongestAhead) - filter.t;
  return ahead > 0 ? Vector3(filter.x.head<3>() + to_seconds(ahead) * filter.x.tail<3>()) : filter.x.head<3>();
}

// State carried forward to now. Beyond kLongestAhead the position is held and becomes uncertain with kUnseenGrowth_mps.
Neighbor NeighborMemory::now_of(const Filter& filter) const {
  const TimeNs now = now_;
  Neighbor neighbor{filter.key,
                    filter.x.head<3>(),
                    filter.x.tail<3>(),
                    filter.seen,
                    filter.P.topLeftCorner<3, 3>(),
                    filter.P.bottomRightCorner<3, 3>()};
  neighbor.seen_local_m = filter.x.head<3>();
  neighbor.seen_covariance_local_m2 = filter.P.topLeftCorner<3, 3>();
  neighbor.own_seen_local_m = filter.own_local_m;
  neighbor.in_view = filter.in_view;
  Filter ahead = filter;
  predict(ahead, std::min(now, filter.t + kLongestAhead));
  neighbor.position_local_m = ahead.x.head<3>();
  neighbor.covariance_local_m2 = ahead.P.topLeftCorner<3, 3>();
  neighbor.velocity_covariance_local_m2ps2 = ahead.P.bottomRightCorner<3, 3>();
  if (now > ahead.t) {
    neighbor.unpredicted_s = to_seconds(now - ahead.t);
    if (now - ahead.t > kLongestMotion) {
      neighbor.unpredicted_s = 0.0;
      neighbor.velocity_local_mps.setZero();
    }
    const double beyond_m = kUnseenGrowth_mps * to_seconds(now - ahead.t);
    neighbor.covariance_local_m2 += beyond_m * beyond_m * Matrix3::Identity();
  }
  return neighbor;
}

bool NeighborMemory::is_any(bool (NeighborView::*sees)(const Vector3&) const, const Vector3& p_body_m) const {
  return views_.empty() ||
         std::any_of(views_.begin(), views_.end(), [&](const NeighborView& view) { return (view.*sees)(p_body_m); });
}

void NeighborMemory::forget(TimeNs now) {
  const TimeNs passed = last_ < 0 ? 0 : now - last_, timeout = from_seconds(config_.timeout_s);
  last_ = now;
  timing_.longest_s *= 1.0 - std::min(1.0, to_seconds(passed) / kFade_s);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < filters_.size(); ++i) {
    if (filters_[i].in_view) filters_[i].missed += passed;
    if (filters_[i].looked_at) filters_[i].unseen_in_view += passed;
    timing_.longest_s = std::max(timing_.longest_s, std::min(to_seconds(filters_[i].missed), kLongestInterval_s));
    if ((config_.remember_hidden ? filters_[i].unseen_in_view : now - filters_[i].seen) > timeout) continue;
    if (kept < i) filters_[kept] = filters_[i];
    ++kept;
  }
  filters_.resize(kept);
}

void NeighborMemory::receive(const Message& message, const GuidanceInput& input) {
  NeighborPosition report;
  if (read_message(message, report) != Reading::kDone || !report.p_world_m.allFinite()) return;
  measure(message.from, report.t, FrameChange::to_local(input.estimate).point(report.p_world_m),
          kRadioVariance_m2 * Matrix3::Identity(), input.poses.at(report.t).translation());
}

void NeighborMemory::announce(const StateEstimate& estimate, Outbox& outbox) const {
  if (config_.source != NeighborSourceConfig::Source::kRadio) return;
  write_message(NeighborPosition{estimate.t, estimate.T_world_body().translation()}, outbox.add());
}

void NeighborMemory::predict(Filter& filter, TimeNs t) const {
  const double dt_s = to_seconds(t - filter.t);
  if (dt_s <= 0.0) return;
  Matrix6 F = Matrix6::Identity();
  F.topRightCorner<3, 3>().diagonal().setConstant(dt_s);
  // Process noise: acceleration constant over the step.
  Eigen::Matrix<double, 6, 3> G;
  G << 0.5 * dt_s * dt_s * Matrix3::Identity(), dt_s * Matrix3::Identity();
  const double variance = config_.acceleration_sigma_mps2 * config_.acceleration_sigma_mps2;
  filter.x = (F * filter.x).eval();
  filter.P = (F * filter.P * F.transpose() + variance * G * G.transpose()).eval();
  filter.t = t;
}

void NeighborMemory::measure(std::int64_t key, TimeNs t, const Vector3& position_local_m, const Matrix3& covariance,
                             const Vector3& own_local_m) {
  timing_.latency_s = std::max(timing_.latency_s, to_seconds(now_ - t));
  const auto known = std::lower_bound(filters_.begin(), filters_.end(), key,
                                      [](const Filter& f, std::int64_t wanted) { return f.key < wanted; });
  if (known == filters_.end() || known->key != key) {
    Filter& filter = *filters_.emplace(known);
    filter.key = key;
    filter.t = filter.seen = t;
    filter.own_local_m = own_local_m;
    filter.x.head<3>() = position_local_m;
    filter.P.topLeftCorner<3, 3>() = covariance;
    filter.P.bottomRightCorner<3, 3>() *= config_.first_speed_sigma_mps * config_.first_speed_sigma_mps;
    return;
  }
  Filter& filter = *known;
  if (t < filter.t) return;  // older than the state
  const double interval_s = to_seconds(t - filter.seen);
  if (interval_s > 0.0)
    timing_.shortest_s = timing_.shortest_s > 0.0 ? std::min(timing_.shortest_s, interval_s) : interval_s;
  predict(filter, t);
  filter.seen = t;
  filter.own_local_m = own_local_m;
  filter.missed = filter.unseen_in_view = 0;
  const Matrix3 S = filter.P.topLeftCorner<3, 3>() + covariance;
  const Eigen::Matrix<double, 6, 3> K = filter.P.leftCols<3>() * S.inverse();
  filter.x += K * (position_local_m - filter.x.head<3>());
  Matrix6 rest = Matrix6::Identity();
  rest.leftCols<3>() -= K;
  filter.P = (rest * filter.P * rest.transpose() + K * covariance * K.transpose()).eval();  // Joseph's form
}

}  // namespace swiftlet
