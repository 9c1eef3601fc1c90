// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "swiftlet/core/localization/motion_match.hpp"
#include "swiftlet/core/localization/relative_alignment.hpp"
#include "swiftlet/core/localization/relative_filter.hpp"
#include "swiftlet/core/localization/relative_localizer.hpp"
#include "swiftlet/core/messages/odometry_report.hpp"

namespace swiftlet {

OtherMotion motion_of(const OdometryReport& report);

/// How far another clock is behind, from what came: a message takes some time, the quickest one nearly none.
class OtherClock {
 public:
  OtherClock(SlidingWindowConfig::Clock mode, double sigma_s, double least_delay_s)
      : one_way_(mode == SlidingWindowConfig::Clock::kOneWay), sigma_s_(sigma_s), least_delay_s_(least_delay_s) {}

  /// The stamp in a time that is the own one but for a little. False: the clock has jumped since the last one.
  bool take(TimeNs& stamp, TimeNs received);
  ClockPrior prior() const;

 private:
  static constexpr int kRemembered = 64;  // half a minute: a clock that drifts moves little
  bool one_way_;
  double sigma_s_, least_delay_s_;
  TimeNs epoch_ = 0, last_ = 0;
  std::array<double, kRemembered> took_s_{};
  int next_ = 0, count_ = 0;
};

/// One other vehicle: what it tells and where it was seen, window and filter. Whose sightings are whose is not decided
/// here.
class Teammate {
 public:
  Teammate(VehicleId id, const SlidingWindowConfig& config);

  VehicleId id() const { return id_; }
  /// Its place and heading are known.
  bool known() const { return filter_.started(); }

  /// True when it told something new.
  bool hear(std::span<const Message> messages);
  /// Of what is known: squared distance from where it is expected, in standard deviations.
  double squared_sigmas(const Sighting& sighting) const { return filter_.squared_sigmas(sighting); }
  /// The same by likelihood: a wide guess does not claim what a narrow one explains.
  double unlikelihood(const Sighting& sighting) const { return filter_.unlikelihood(sighting); }
  Vector3 place_local_m() const { return last_.position_m; }
  /// Of what is known: takes its own sighting. False when it is no sighting of this vehicle.
  bool take(const Sighting& sighting);
  /// Of what is known: what shines elsewhere is it, perhaps, when it was not seen where it should be for so long.
  void doubt(TimeNs t);
  /// A sighting that may well be of this vehicle waits for odometry that is newer.
  void wait(const Sighting& sighting);
  /// The same of a chain of them; those that came before are left out.
  void wait_for_new_of(std::span<const Sighting> chain);
  MotionMatch match(std::span<const Sighting> chain) const;
  /// Pairs what waits; with something new, the window is fitted.
  void update(bool heard);
  /// The estimate of now, when there is one that is sure.
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
  std::optional<double> clock_s_;  // found with the alignment
  RelativeOdometry odometry_;      // by the other clock, near the own one
  RelativeAlignment alignment_;
  RelativeFilter filter_;
  RelativeEstimate last_;          // for pictures
  std::vector<Sighting> waiting_;  // for odometry that is newer
  TimeNs last_pair_ = 0, last_accepted_ = 0, last_waiting_ = 0;
  int num_disagreements_ = 0;
  std::uint64_t num_reports_ = 0, num_late_ = 0, num_starts_ = 0, num_lost_ = 0;
};

}  // namespace swiftlet
