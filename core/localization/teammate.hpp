// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/localization/motion_match.hpp"
#include "core/localization/relative_filter.hpp"
#include "swiftlet/core/localization/relative_alignment.hpp"
#include "swiftlet/core/localization/relative_localizer.hpp"
#include "swiftlet/core/messages/odometry_report.hpp"

namespace swiftlet {

OtherMotion motion_of(const OdometryReport& report);

/// Estimates the offset of another clock from message delays: the fastest message has nearly none.
class OtherClock {
 public:
  OtherClock(SlidingWindowConfig::Clock mode, double sigma_s, double least_delay_s)
      : one_way_(mode == SlidingWindowConfig::Clock::kOneWay), sigma_s_(sigma_s), least_delay_s_(least_delay_s) {}

  /// Unwraps the stamp to a time near the own clock. False when the other clock has jumped since the last message.
  bool take(TimeNs& stamp, TimeNs received);
  ClockPrior prior() const;

 private:
  static constexpr int kNumDelays = 64;  // number of delays in the window: half a minute, in which drift is small
  bool one_way_;
  double sigma_s_, least_delay_s_;
  TimeNs epoch_ = 0, last_ = 0;
  std::array<double, kNumDelays> delays_s_{};
  int next_ = 0, count_ = 0;
};

/// Another vehicle: its odometry and sightings, the window and the filter. The assignment of sightings to vehicles is
/// decided elsewhere.
class Teammate {
 public:
  Teammate(VehicleId id, const SlidingWindowConfig& config);

  VehicleId id() const { return id_; }
  /// True once position and heading are estimated.
  bool known() const { return filter_.started(); }

  /// Returns true when the messages contain new odometry.
  bool receive(std::span<const Message> messages);
  /// Squared distance from the predicted position, in standard deviations; the vehicle must be known.
  double squared_sigmas(const Sighting& sighting) const { return filter_.squared_sigmas(sighting); }
  /// -2 log likelihood but for a constant: a wide estimate does not claim sightings that a narrow one explains.
  double unlikelihood(const Sighting& sighting) const { return filter_.unlikelihood(sighting); }
  Vector3 place_local_m() const { return last_.position_m; }
  /// Applies a sighting of this vehicle to the filter and queues it for the window; the vehicle must be known. False
  /// when the filter rejects it.
  bool take(const Sighting& sighting);
  /// Drops the estimate after reacquire_s without an accepted sighting, as a sighting elsewhere may be this vehicle.
  void mark_ambiguous(TimeNs t);
  /// Queues a possible sighting of this vehicle until newer odometry arrives.
  void wait(const Sighting& sighting);
  /// Queues the new sightings of a chain.
  void wait_for_new_of(std::span<const Sighting> chain);
  MotionMatch match(std::span<const Sighting> chain) const;
  /// Pairs queued sightings; fits the window when new odometry was received.
  void update(bool has_report);
  /// Present estimate, if it is certain enough.
  std::optional<RelativeEstimate> estimate(TimeNs t);

  void append_overlays(std::vector<Overlay>& overlays) const;
  std::uint64_t num_reports() const { return num_reports_; }
  std::uint64_t num_late() const { return num_late_; }
  std::uint64_t num_starts() const { return num_starts_; }
  std::uint64_t num_lost() const { return num_lost_; }

 private:
  void start_over();
  double clock_s() const { return clock_s_ ? *clock_s_ : clock_.prior().clock_s; }
  OtherMotion in_own_time(OtherMotion motion) const;
  void pair();
  void align();
  bool agrees(const FrameAlignment& found);
  bool is_sure(const RelativeEstimate& estimate) const;

  SlidingWindowConfig config_;
  VehicleId id_;
  OdometryDrift drift_;
  OtherClock clock_;
  std::optional<double> clock_s_;  // result of the alignment
  RelativeOdometry odometry_;      // stamped by the other clock, unwrapped to near the own one
  RelativeAlignment alignment_;
  RelativeFilter filter_;
  RelativeEstimate last_;          // for pictures
  std::vector<Sighting> waiting_;  // until newer odometry arrives
  TimeNs last_pair_ = 0, last_accepted_ = 0, last_waiting_ = 0;
  int num_disagreements_ = 0;
  std::uint64_t num_reports_ = 0, num_late_ = 0, num_starts_ = 0, num_lost_ = 0;
};

}  // namespace swiftlet
