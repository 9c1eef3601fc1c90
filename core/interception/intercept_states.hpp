// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/interception/intercept_config.hpp"

namespace swiftlet {

/// States of an interception and their transitions.
class InterceptStates {
 public:
  /// [s] Longest time for which the vehicle flies away from a captured target before the next approach. Larger values
  /// leave more distance and lose time.
  static constexpr double kAfterCapture_s = 2.0;
  enum class State { kWaiting, kChasing, kLeaving, kSearching, kAborted, kDone };

  /// Observations of one tick.
  struct Inputs {
    bool sees_target = false;        ///< the target has a track
    bool had_target = false;         ///< the target has had a track before; false: a teammate reported it
    bool is_outside = false;         ///< the target is outside the fence
    bool is_reported = false;        ///< a teammate sees a target, and this vehicle goes there
    bool is_armed = false;           ///< the net may capture again
    bool captures = false;           ///< the net captures the target now
    int num_captures = 0;            ///< captures so far
    bool teammate_captured = false;  ///< a teammate has captured the same target
  };

  explicit InterceptStates(const InterceptConfig& config);

  void step(const Inputs& inputs, double dt_s);
  /// The target was a teammate: waits for another target.
  void drop_target();

  State state() const { return state_; }
  bool is(State state) const { return state_ == state; }
  /// Pursues a target, or leaves it after a capture.
  bool has_target() const { return is(State::kChasing) || is(State::kLeaving); }
  /// True if a state was entered since the last call.
  bool take_entry();
  /// Time for which the target has been outside the fence.
  double outside_s() const { return outside_s_; }
  const char* note() const { return note_; }
  MissionStatus status() const;

 private:
  void follow_target(const Inputs& inputs, double dt_s);
  void end_missions(const Inputs& inputs);
  void enter(State state);
  void give_up(const char* reason);

  bool leaves_after_capture_;
  int wanted_captures_;
  double fence_patience_s_, search_timeout_s_;
  State state_ = State::kWaiting;
  bool entered_ = false;
  const char* note_ = "";
  double in_state_s_ = 0.0, outside_s_ = 0.0;
};

}  // namespace swiftlet
