// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/intercept_states.hpp"

#include <utility>

namespace swiftlet {

InterceptStates::InterceptStates(const InterceptConfig& config)
    : leaves_after_capture_(config.method == InterceptConfig::Method::kMpc),
      wanted_captures_(config.captures),
      fence_patience_s_(config.fence.patience_s),
      search_timeout_s_(config.search.timeout_s) {}

void InterceptStates::step(const Inputs& inputs, double dt_s) {
  in_state_s_ += dt_s;
  follow_target(inputs, dt_s);
  if (!is(State::kAborted) && !is(State::kDone)) end_missions(inputs);
}

void InterceptStates::follow_target(const Inputs& inputs, double dt_s) {
  switch (state_) {
    case State::kWaiting:
      note_ = "waiting for a target";
      if (inputs.sees_target)
        enter(State::kChasing);
      else if (inputs.is_reported)
        enter(State::kSearching);
      break;
    case State::kSearching:
      note_ = inputs.had_target ? "target lost: searching" : "flying to a target reported by a teammate";
      if (inputs.is_reported) in_state_s_ = 0.0;
      if (inputs.sees_target)
        enter(State::kChasing);
      else if (in_state_s_ > search_timeout_s_)
        give_up("gave up: the target was not found again");
      break;
    case State::kLeaving:
      note_ = "captured";
      if (inputs.is_armed || in_state_s_ > kAfterCapture_s) enter(State::kChasing);
      break;
    case State::kChasing:
      note_ = "chasing";
      outside_s_ = inputs.is_outside ? outside_s_ + dt_s : 0.0;
      if (!inputs.sees_target)
        enter(State::kSearching);
      else if (outside_s_ > fence_patience_s_)
        give_up("gave up: the target left the fence");
      break;
    case State::kAborted:
    case State::kDone:
      break;
  }
}

void InterceptStates::end_missions(const Inputs& inputs) {
  if (inputs.captures) {
    note_ = "captured";
    if (wanted_captures_ > 0 && inputs.num_captures >= wanted_captures_)
      enter(State::kDone);
    else if (leaves_after_capture_)
      enter(State::kLeaving);
  }
  if (wanted_captures_ > 0 && inputs.teammate_captured && !is(State::kDone)) {
    note_ = "a teammate has captured the target";
    enter(State::kDone);
  }
}

void InterceptStates::drop_target() {
  if (has_target() || is(State::kSearching)) enter(State::kWaiting);
}

void InterceptStates::enter(State state) {
  if (state == State::kChasing && state_ != State::kLeaving) outside_s_ = 0.0;
  state_ = state;
  in_state_s_ = 0.0;
  entered_ = true;
}

void InterceptStates::give_up(const char* reason) {
  note_ = reason;
  enter(State::kAborted);
}

bool InterceptStates::take_entry() { return std::exchange(entered_, false); }

MissionStatus InterceptStates::status() const {
  return is(State::kDone)      ? MissionStatus::kDone
         : is(State::kAborted) ? MissionStatus::kFailed
                               : MissionStatus::kRunning;
}

}  // namespace swiftlet
