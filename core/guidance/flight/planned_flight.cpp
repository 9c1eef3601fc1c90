// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/flight/planned_flight.hpp"

namespace swiftlet {

PlannedFlight::PlannedFlight(const GuidanceSetup& setup, const Rules& rules, const PathFollower& follower)
    : planner_(rules.planning_latency_s), follower_(follower), rules_(rules), state_(rules.first) {
  hold_.position_m = setup.agent.T_local_body_start.translation();
  hold_.yaw_rad = yaw_of(setup.agent.T_local_body_start.linear());
}

void PlannedFlight::step(const GuidanceInput& input, GuidanceOutput& output, Outbox&) {
  now_ = input.observation.t;
  if (!started_) enter(rules_.first);
  started_ = true;
  if (state_ == State::kLooking) {
    look(input);
  } else if (state_ == State::kPlanning) {
    plan(input);
  } else if (state_ == State::kFlying) {
    follow(input);
  } else if (state_ == State::kFailure && failures_ <= rules_.retries && waited(rules_.retry_after_s)) {
    enter(rules_.first);
  }
  output.goal = hold_;
  output.speed_limit_mps = rules_.speed_mps;
  const bool failed = state_ == State::kFailure;
  output.note = failed ? reason_ : note_of(state_);
  output.mission = failed && failures_ > rules_.retries ? MissionStatus::kFailed
                   : state_ == State::kDone             ? rules_.end
                                                        : MissionStatus::kRunning;
}

void PlannedFlight::enter(State state) {
  state_ = state;
  entered_ = now_;
  planner_.stop();
}

void PlannedFlight::fail(const char* reason) {
  reason_ = reason;
  ++failures_;
  enter(State::kFailure);
}

}  // namespace swiftlet
