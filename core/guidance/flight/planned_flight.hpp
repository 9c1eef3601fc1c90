// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/guidance/flight/path_follower.hpp"
#include "swiftlet/core/math/latency.hpp"

namespace swiftlet {

/// Guidance that plans while the vehicle hovers, and then follows the path. After a failure it waits and begins again.
class PlannedFlight : public Guidance {
 public:
  GuidanceNeeds needs() const override { return {.map = true}; }
  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox& outbox) final;

 protected:
  enum class State { kLooking, kPlanning, kFlying, kDone, kFailure };
  struct Rules {
    double speed_mps, planning_latency_s, retry_after_s;
    int retries;
    State first;                               ///< state at the start and after a failure
    MissionStatus end = MissionStatus::kDone;  ///< mission in the state kDone
  };

  PlannedFlight(const GuidanceSetup& setup, const Rules& rules, const PathFollower& follower);

  virtual void look(const GuidanceInput&) {}
  virtual void plan(const GuidanceInput& input) = 0;
  virtual void follow(const GuidanceInput& input) = 0;
  /// Text of a state other than kFailure.
  virtual const char* note_of(State state) const = 0;

  void enter(State state);
  /// True when the present state has lasted for this time.
  bool waited(double seconds) const { return now_ - entered_ >= from_seconds(seconds); }
  void fail(const char* reason);
  void succeed() { failures_ = 0; }

  TimeNs now_ = 0;
  Worker planner_;
  PathFollower follower_;
  Reference hold_;
  std::uint64_t num_plans_ = 0, num_given_up_ = 0;

 private:
  Rules rules_;
  State state_;
  bool started_ = false;
  TimeNs entered_ = 0;
  int failures_ = 0;
  const char* reason_ = "";
};

}  // namespace swiftlet
