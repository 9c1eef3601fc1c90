// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "swiftlet/core/base/counter.hpp"
#include "swiftlet/core/guidance/guide.hpp"
#include "swiftlet/core/math/latency.hpp"

namespace swiftlet {

/// Plans of the present and the next leg. A plan is ready after the computing time on board.
class LegPlanner {
 public:
  /// @param config  must outlive this object
  explicit LegPlanner(const GuideConfig& config) : config_(config.planner), worker_(config.planning_latency_s) {}

  bool idle() const { return worker_.idle(); }
  bool ready(TimeNs now) const { return worker_.due(now); }
  /// Plans a leg from the present poses.
  void start(const GuidanceInput& input, const PlannedPose& from, const PlannedPose& goal, const TeamTraffic& traffic);
  /// Plans the leg after the present one. A plan by which no vehicle can move is dropped; the leg is planned again when
  /// both hover, and then states the reason.
  void start_next(const GuidanceInput& input, const PlannedPose& goal, double yaw_rad, const TeamTraffic& traffic);
  /// Drops the finished plan, after the caller has taken it.
  void finish() { worker_.stop(); }
  void reset() {
    worker_.stop();
    next_.reset();
  }
  const std::optional<TeamPlan>& plan() const { return plan_; }
  const std::optional<TeamPlan>& next() const { return next_; }
  /// Makes the next leg the present one.
  void take_next();
  void append_counters(std::vector<Counter>& counters) const;

 private:
  TeamPlan plan_leg(const GuidanceInput& input, const PlannedPose& from, const PlannedPose& goal,
                    const TeamTraffic& traffic);

  const TeamPlannerConfig& config_;
  Worker worker_;
  std::optional<TeamPlan> plan_, next_;
  std::uint64_t num_plans_ = 0, num_given_up_primary_ = 0, num_given_up_secondary_ = 0;
};

}  // namespace swiftlet
