// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/kept_apart.hpp"

#include <algorithm>
#include <span>
#include <utility>

#include "core/guidance/gliding_goal.hpp"
#include "core/guidance/guidance_constants.hpp"
#include "core/guidance/separation/neighbor_safety.hpp"

namespace swiftlet {
namespace {

/// [-] Rounds of projections onto the planes. With fewer, a goal among many neighbors stays farther behind some plane,
/// and the vehicle waits.
constexpr int kProjections = 30;

/// Heights relative to the vehicle.
struct Heights {
  double low_m, high_m;
};

/// Moves a point into the half-spaces, plane by plane, and between the heights. Returns whether it lies in all of them.
bool move_within(std::span<const HalfSpace> planes, const Heights& heights, Vector3& q_m) {
  for (int round = 0; round < kProjections; ++round) {
    bool inside = true;
    for (const HalfSpace& plane : planes) {
      const double beyond_m = plane.normal_local.dot(q_m) - plane.offset_m;
      if (beyond_m <= kOnPlane_m) continue;
      q_m -= beyond_m * plane.normal_local;
      inside = false;
    }
    if (inside) return true;
    q_m.z() = std::clamp(q_m.z(), heights.low_m, heights.high_m);
  }
  return false;
}

class KeptApart : public Guidance {
 public:
  KeptApart(std::unique_ptr<Guidance> guidance, const KeepApartConfig& config, const GuidanceSetup& setup, bool planar)
      : guidance_(std::move(guidance)),
        config_(config),
        planar_(planar),
        period_(from_seconds(kUpdatePeriod_s)),
        neighbors_(config.neighbors, setup.agent.neighbor_views),
        safety_(config, {.limits = setup.limits,
                         .views = setup.agent.neighbor_views,
                         .encumbrance_m = config.encumbrance_m,
                         .period = period_,
                         .planar = planar,
                         .num_vehicles = setup.agent.num_vehicles}) {}

  GuidanceNeeds needs() const override {
    GuidanceNeeds needs = guidance_->needs();
    needs.neighbors = needs.neighbors || config_.neighbors.source == NeighborSourceConfig::Source::kSensor;
    return needs;
  }

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox& outbox) override {
    const TimeNs now = input.observation.t;
    guidance_->step(input, output, outbox);
    neighbors_.update(input);
    if (next_update_ == 0) {
      safety_.start(input.estimate);
      goal_.position_m = input.estimate.T_local_body.translation();
    }
    output.speed_limit_mps = std::min(output.speed_limit_mps, safety_.speed_limit_mps(neighbors_.timing()));
    if (now >= next_update_) {
      next_update_ = next_update_ == 0 ? now + period_ : next_update_ + period_;
      plan(input.estimate, output, now);
      neighbors_.announce(input.estimate, outbox);
    }
    goal_.position_m = glide_.at(now, next_update_, period_, from_seconds(input.dt_s));
    output.goal = safety_.step(goal_, input.dt_s, output.speed_limit_mps);
    output.goal_is_feasible = true;
  }

  void append_overlays(std::vector<Overlay>& overlays) const override { guidance_->append_overlays(overlays); }
  void append_counters(std::vector<Counter>& counters) const override { guidance_->append_counters(counters); }

 private:
  void plan(const StateEstimate& estimate, const GuidanceOutput& wanted, TimeNs now) {
    const FrameChange to_local = FrameChange::to_local(estimate);
    const Vector3 p_local_m = estimate.T_local_body.translation();
    const NeighborSafety::Situation situation{.estimate = estimate,
                                              .neighbors = neighbors_.neighbors(),
                                              .timing = neighbors_.timing(),
                                              .z_min_m = to_local.height(config_.z_min_m),
                                              .z_max_m = to_local.height(config_.z_max_m),
                                              .now = now};
    Vector3 to_goal_m = wanted.goal.position_m - p_local_m;
    safety_.update(situation);
    // Neighbors push the goal up or down within the heights; guidance itself may leave them, as in a landing.
    const Heights heights{std::min({situation.z_min_m - p_local_m.z(), to_goal_m.z(), 0.0}),
                          std::max({situation.z_max_m - p_local_m.z(), to_goal_m.z(), 0.0})};
    if (!move_within(safety_.planes(), heights, to_goal_m)) {
      safety_.update(situation, true);
      move_within(safety_.planes(), heights, to_goal_m);
    }
    const NeighborSafety::Goal admitted = safety_.admit(situation, {.last_local_m = goal_.position_m,
                                                                    .position_local_m = p_local_m + to_goal_m,
                                                                    .yaw_rad = wanted.goal.yaw_rad,
                                                                    .speed_limit_mps = wanted.speed_limit_mps});
    glide_ = {goal_.position_m, admitted.position_local_m};
    goal_.yaw_rad = admitted.yaw_rad;
    if (!planar_) return;
    const double height_m = wanted.goal.position_m.z();
    glide_.to_local_m.z() = safety_.evasion_height_local_m(situation, height_m).value_or(height_m);
  }

  std::unique_ptr<Guidance> guidance_;
  KeepApartConfig config_;
  bool planar_;
  TimeNs period_, next_update_ = 0;
  NeighborMemory neighbors_;
  NeighborSafety safety_;
  GlidingGoal glide_;
  Reference goal_;
};

}  // namespace

std::unique_ptr<Guidance> kept_apart(std::unique_ptr<Guidance> guidance, const KeepApartConfig& config,
                                     const GuidanceSetup& setup, bool planar) {
  if (!config.enabled) return guidance;
  return std::make_unique<KeptApart>(std::move(guidance), config, setup, planar);
}

}  // namespace swiftlet
