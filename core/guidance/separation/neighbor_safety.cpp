// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/separation/neighbor_safety.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet {
namespace {

constexpr double kFar_m = std::numeric_limits<double>::infinity();

/// Constants of the rules.
struct Rule {
  /// [s] Delay before a vehicle brakes, in addition to the period of the updates. Larger values keep more distance and
  /// slow the vehicle down.
  static constexpr double kReaction_s = 0.2;
  /// [m] Violation of a plane above which the vehicle evades. Smaller values evade for noise.
  static constexpr double kViolation_m = 0.01;
  /// [s] Time without measurement after which a neighbor no longer shrinks the cell below kMinCellSize_m. Larger values
  /// slow the team down after a dropout.
  static constexpr double kLongUnseen_s = 5.0;
  /// [m] Smallest cell radius left by a neighbor unseen for kLongUnseen_s. At 0 the vehicle retreats indefinitely.
  static constexpr double kMinCellSize_m = 1.0;
  /// [s] Time before the braking paths come too close at which the evasion begins. Larger values evade earlier.
  static constexpr double kEvade_s = 0.5;
  /// [s] Time after the last approach until a planar vehicle returns to its plane.
  /// Smaller values may return below or above a neighbor.
  static constexpr double kOutOfPlane_s = 1.5;
  /// [m] Height of a neighbor above a planar vehicle from which the vehicle evades downwards instead of upwards.
  static constexpr double kSameHeight_m = 0.3;
};

double range_of(const std::vector<NeighborView>& views) {
  double range_m = kFar_m;
  for (const NeighborView& view : views) range_m = std::min(range_m, view.range_max_m);
  return range_m;
}

}  // namespace

NeighborSafety::NeighborSafety(const SeparationConfig& config, const Vehicle& vehicle)
    : config_(config),
      vehicle_(vehicle),
      distance_m_(config.distance_m(vehicle.encumbrance_m)),
      vertical_m_(vehicle.planar ? distance_m_ : config.vertical_m),
      reaction_s_(Rule::kReaction_s + to_seconds(vehicle.period)),
      range_m_(range_of(vehicle.views)),
      reference_(config.within(vehicle.limits), vehicle.planar),
      sight_(vehicle.views) {
  vehicle_.limits = config.within(vehicle.limits);
  const auto num = static_cast<std::size_t>(vehicle.num_vehicles);
  planes_.reserve(3 * num);
  cell_planes_.reserve(3 * num);
}

void NeighborSafety::start(const StateEstimate& estimate) {
  Reference here;
  here.position_m = estimate.T_local_body.translation();
  here.velocity_mps = estimate.v_local_mps;
  here.yaw_rad = yaw_of(estimate.T_local_body.linear());
  reference_.reset(here);
}

void NeighborSafety::update(const Situation& situation, bool certain) {
  sigmas_ = certain ? 0.0 : config_.sigmas;
  self_ = {level(situation.estimate.T_local_body.translation()), level(reference_.rest_local_m())};
  planes_.clear();
  cell_planes_.clear();
  evades_ = false;
  passing_at_m_ = kFar_m;
  for (const Neighbor& neighbor : situation.neighbors) {
    const Vector3 p_local_m = level(neighbor.position_local_m);
    const Encounter met{neighbor, p_local_m, level(neighbor.velocity_local_mps), p_local_m - self_.p_local_m};
    const Braking other =
        braking_of(met.p_local_m, met.v_local_mps, reaction_s_ + neighbor.unpredicted_s, vehicle_.limits);
    add_braking_plane(met, other, situation);
    maybe_evade(met, other, situation.now);
    add_pledge_plane(met, situation);
  }
}

/// Plane between the braking paths. While a neighbor's pledge holds, only the uncertainty of its last measured position
/// counts.
void NeighborSafety::add_braking_plane(const Encounter& met, const Braking& other, const Situation& situation) {
  // Derivative of the neighbor's stopping distance v t + v^2 / 2a with respect to its closing speed.
  const double velocity_gain_s = reaction_s_ + met.closing_mps / vehicle_.limits.horizontal_acceleration_mps2;
  const double sigma_m = met.sigma(met.neighbor.covariance_local_m2) + velocity_gain_s * met.speed_sigma_mps();
  double reserve_m = sigmas_ * sigma_m;
  if (is_pledged(met.neighbor, situation)) reserve_m = std::min(seen_reserve_m(met), reserve_m);
  const HalfSpace plane = braking_plane(self_, other, distance_m_, vertical_m_, reserve_m);
  evades_ = evades_ || plane.offset_m < -Rule::kViolation_m;
  double cell_m = plane.offset_m;
  if (to_seconds(situation.now - met.neighbor.seen) > Rule::kLongUnseen_s) {
    const double sure_m = braking_plane(self_, other, distance_m_, vertical_m_, 0.0).offset_m;
    cell_m = std::max(cell_m, std::min(sure_m, Rule::kMinCellSize_m));
  }
  add(plane, cell_m);
}

/// Evades a neighbor that approaches without braking: a braking neighbor is already slow.
void NeighborSafety::maybe_evade(const Encounter& met, const Braking& other, TimeNs now) {
  if (met.closing_mps <= Encounter::kClosing_mps) return;
  const double sure_m = braking_plane(self_, other, distance_m_, vertical_m_, 0.0).offset_m;
  if (sure_m >= 0.5 * Rule::kEvade_s * met.closing_mps) return;
  if (met.distance_m < passing_at_m_) {
    passing_at_m_ = met.distance_m;
    passing_ = {now, met.neighbor.position_local_m.z()};
  }
  const auto beside = evasion_plane(self_, met.p_local_m, met.v_local_mps, distance_m_, vertical_m_, vehicle_.limits);
  if (!beside) return;
  evades_ = evades_ || beside->offset_m < -Rule::kViolation_m;
  add(*beside, beside->offset_m);
}

/// Adds the half-space of the vehicle's own pledge.
void NeighborSafety::add_pledge_plane(const Encounter& met, const Situation& situation) {
  // Samples may be lost, so the vehicle keeps its pledge for longer than it relies on that of the neighbor.
  const double kept_s = 2.0 * sample_gap_s(situation.timing) + situation.timing.longest_s;
  if (config_.pledge_share <= 0.0 || to_seconds(situation.now - met.neighbor.seen) > kept_s) return;
  const HalfSpace pledge =
      pledge_plane(level(met.neighbor.own_seen_local_m), level(met.neighbor.seen_local_m), self_.p_local_m, distance_m_,
                   vertical_m_, seen_reserve_m(met), config_.pledge_share);
  add(pledge, pledge.offset_m);
}

void NeighborSafety::add(const HalfSpace& plane, double cell_offset_m) {
  planes_.push_back(plane);
  cell_planes_.push_back({plane.normal_local, cell_offset_m});
}

NeighborSafety::Goal NeighborSafety::admit(const Situation& situation, Goal wanted,
                                           std::span<const HalfSpace> obstacles) {
  const Pose& T_local_body = situation.estimate.T_local_body;
  if (vehicle_.turns) {
    wanted.yaw_rad =
        sight_.heading(T_local_body, wanted.position_local_m, situation.neighbors, wanted.yaw_rad, situation.now);
    if (!evades_ && !sight_.sees_ahead(T_local_body, wanted.position_local_m))
      wanted.position_local_m = reference_.rest_local_m();
  }
  if (evades_) {  // within the heights of flight
    const double z_m = T_local_body.translation().z();
    double& goal_z_m = wanted.position_local_m.z();
    goal_z_m = std::clamp(goal_z_m, std::min(situation.z_min_m, z_m), std::max(situation.z_max_m, z_m));
    planes_.insert(planes_.end(), obstacles.begin(), obstacles.end());
  }
  wanted.position_local_m =
      reference_.admit(wanted.last_local_m, wanted.position_local_m, planes_, T_local_body.translation(),
                       to_seconds(vehicle_.period), wanted.speed_limit_mps);
  return wanted;
}

std::optional<double> NeighborSafety::evasion_height_local_m(const Situation& situation, double height_m) {
  if (passing_.t < 0 || situation.now - passing_.t > from_seconds(Rule::kOutOfPlane_s)) {
    rises_.reset();
    return std::nullopt;
  }
  const auto to_m = [&](bool rises) { return passing_.height_local_m + (rises ? 1.0 : -1.0) * config_.vertical_m; };
  const auto is_free = [&](bool rises) {
    return rises ? to_m(true) <= situation.z_max_m : to_m(false) >= situation.z_min_m;
  };
  const double z_m = situation.estimate.T_local_body.translation().z();
  if (!rises_) rises_ = z_m >= passing_.height_local_m - Rule::kSameHeight_m;
  if (!is_free(*rises_) && is_free(!*rises_)) rises_ = !*rises_;
  const double aside_m = *rises_ ? std::max(height_m, to_m(true)) : std::min(height_m, to_m(false));
  return std::clamp(aside_m, std::min(situation.z_min_m, height_m), std::max(situation.z_max_m, height_m));
}

double NeighborSafety::speed_limit_mps(const SampleTiming& timing) const {
  const double unknown_s = timing.longest_s + timing.latency_s + Rule::kReaction_s + to_seconds(vehicle_.period);
  return speed_into_unknown_mps(range_m_, unknown_s, distance_m_, vehicle_.limits.horizontal_acceleration_mps2);
}

/// Time after a sample during which the neighbor counts as keeping its pledge.
double NeighborSafety::sample_gap_s(const SampleTiming& timing) const {
  return timing.shortest_s + timing.latency_s + to_seconds(vehicle_.period);
}

bool NeighborSafety::is_pledged(const Neighbor& neighbor, const Situation& situation) const {
  return config_.pledge_share > 0.0 && situation.timing.shortest_s > 0.0 &&
         to_seconds(situation.now - neighbor.seen) <= sample_gap_s(situation.timing);
}

}  // namespace swiftlet
