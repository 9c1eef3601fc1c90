// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/orca.hpp"

#include <algorithm>
#include <cmath>

#include "core/guidance/guidance_constants.hpp"
#include "core/guidance/heading.hpp"
#include "core/guidance/separation/neighbor_memory.hpp"
#include "swiftlet/core/guidance/kept_apart.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// [s] Remaining distance to the goal, or to a height limit, over preferred speed. Larger values brake earlier.
constexpr double kApproach_s = 1.5;
/// [s] Time horizon for which the chosen velocities keep vehicles apart. Larger values evade earlier and fly slower
/// among many neighbors.
constexpr double kOrcaHorizon_s = 4.0;
/// [deg] Turn of the preferred velocity to the right. At 0, two vehicles that fly straight at each other only brake.
constexpr double kOrcaTurn_deg = 5.0;
/// [m/s] Accepted violation of a plane. Larger values accept a velocity after fewer relaxations, and are less safe.
constexpr double kSlack_mps = 5e-3;
/// [-] Projection rounds per search. More rounds are slower and end nearer to the optimum.
constexpr int kRounds = 60;
/// [m/s] First relaxation of all planes when no velocity satisfies them, its factor [-] from trial to trial, and the
/// number [-] of trials. Smaller steps find a velocity closer to the least relaxation.
constexpr double kFirstRelaxation_mps = 0.05, kRelaxationFactor = 1.6;
constexpr int kRelaxations = 12;

Vector3 within(const Vector3& v, double longest) {
  const double length = v.norm();
  return length > longest ? Vector3(longest / length * v) : v;
}

Vector3 unit(const Vector3& v, const Vector3& otherwise) {
  const double length = v.norm();
  return length > kNegligible ? Vector3(v / length) : otherwise;
}

/// Velocity nearest to the wanted one among those that satisfy all planes, each relaxed by relaxation_mps, and the
/// speed limit: alternating projections [Dykstra 1983].
/// @param corrections  scratch memory
Vector3 nearest(std::span<const OrcaPlane> planes, const Vector3& wanted, double speed_mps, double relaxation_mps,
                std::vector<Vector3>& corrections) {
  corrections.assign(planes.size() + 1, Vector3::Zero());
  Vector3 v = wanted;
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t i = 0; i <= planes.size(); ++i) {
      const Vector3 from = v + corrections[i];
      if (i == planes.size()) {
        v = within(from, speed_mps);
      } else {
        const double missing = planes[i].normal_local.dot(planes[i].point_local_mps - from) - relaxation_mps;
        v = missing > 0.0 ? Vector3(from + missing * planes[i].normal_local) : from;
      }
      corrections[i] = from - v;
    }
  }
  return v;
}

bool satisfies(std::span<const OrcaPlane> planes, const Vector3& v, double relaxation_mps) {
  return std::all_of(planes.begin(), planes.end(), [&](const OrcaPlane& plane) {
    return plane.normal_local.dot(v - plane.point_local_mps) > -relaxation_mps - kSlack_mps;
  });
}

class Orca : public Guidance {
 public:
  Orca(const OrcaConfig& config, const GuidanceSetup& setup)
      : config_(config), neighbors_(config.neighbors, setup.agent.neighbor_views) {
    goal_.position_m = setup.agent.T_local_body_start.translation();
    goal_.yaw_rad = yaw_of(setup.agent.T_local_body_start.linear());
  }

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox& outbox) override {
    const FrameChange to_local = FrameChange::to_local(input.estimate);
    const Vector3 p_local_m = input.estimate.T_local_body.translation();
    Vector3 to_goal_m = to_local.point(config_.goal_m) - p_local_m;
    if (config_.planar) to_goal_m.z() = 0.0;
    neighbors_.update(input);
    if (input.observation.t >= next_) {
      next_ = input.observation.t + from_seconds(kUpdatePeriod_s);
      v_local_mps_ = velocity(input.estimate, to_goal_m, to_local);
      neighbors_.announce(input.estimate, outbox);
    }
    arrived_ = arrived_ || to_goal_m.norm() <= config_.arrival_radius_m;
    goal_.position_m = p_local_m + kGoalAhead_s * v_local_mps_;
    if (config_.planar) goal_.position_m.z() = to_local.point(config_.goal_m).z();
    output.goal = goal_;
    output.speed_limit_mps = config_.speed_mps;
    output.mission = arrived_ ? MissionStatus::kDone : MissionStatus::kRunning;
  }

 private:
  Vector3 velocity(const StateEstimate& estimate, const Vector3& to_goal_m, const FrameChange& to_local) {
    const Vector3 p_local_m = estimate.T_local_body.translation();
    const double distance_m = 2.0 * config_.encumbrance_m + config_.margin_m;
    planes_.clear();
    const double step_s = 2.0 * kUpdatePeriod_s;  // vehicles that are too close separate within two updates
    for (const Neighbor& neighbor : neighbors_.neighbors()) {
      planes_.push_back(orca_plane(level(neighbor.position_local_m - p_local_m), level(estimate.v_local_mps),
                                   level(neighbor.velocity_local_mps), distance_m, kOrcaHorizon_s, step_s));
    }
    const Vector3 wanted = Eigen::AngleAxisd(-kOrcaTurn_deg * kRadPerDeg, Vector3::UnitZ()) *
                           within(to_goal_m / kApproach_s, config_.speed_mps);
    if (!config_.planar) {
      const double up_m = to_local.height(config_.z_max_m) - p_local_m.z();
      const double down_m = p_local_m.z() - to_local.height(config_.z_min_m);
      planes_.push_back({Vector3(0.0, 0.0, up_m / kApproach_s), -Vector3::UnitZ()});
      planes_.push_back({Vector3(0.0, 0.0, -down_m / kApproach_s), Vector3::UnitZ()});
    }
    return orca_velocity(planes_, wanted, config_.speed_mps, scratch_);
  }
  Vector3 level(const Vector3& v) const { return config_.planar ? Vector3(v.x(), v.y(), 0.0) : v; }

  OrcaConfig config_;
  NeighborMemory neighbors_;
  std::vector<OrcaPlane> planes_;
  std::vector<Vector3> scratch_;
  TimeNs next_ = 0;
  Vector3 v_local_mps_ = Vector3::Zero();
  Reference goal_;
  bool arrived_ = false;
};

}  // namespace

OrcaPlane orca_plane(const Vector3& to_other_local_m, const Vector3& v_local_mps, const Vector3& other_v_local_mps,
                     double distance_m, double horizon_s, double step_s) {
  const Vector3& p = to_other_local_m;
  const Vector3 v = v_local_mps - other_v_local_mps;
  const double pp = p.squaredNorm(), rr = distance_m * distance_m;
  const Vector3 aside = unit(-p, -Vector3::UnitX());
  Vector3 normal, change;
  const auto off_sphere = [&](double seconds) {
    const Vector3 w = v - p / seconds;
    normal = unit(w, aside);
    change = (distance_m / seconds - w.norm()) * normal;
  };
  if (pp <= rr) {
    off_sphere(step_s);
  } else {
    const Vector3 w = v - p / horizon_s;
    const double along = w.dot(p);
    if (along < 0.0 && along * along > rr * w.squaredNorm()) {
      off_sphere(horizon_s);  // the front of the truncated cone
    } else {                  // the side of the cone
      const double b = p.dot(v), c = v.squaredNorm() - p.cross(v).squaredNorm() / (pp - rr);
      const double t = (b + std::sqrt(std::max(0.0, b * b - pp * c))) / pp;
      const Vector3 off = v - t * p;
      normal = unit(off, aside);
      change = (distance_m * t - off.norm()) * normal;
    }
  }
  return {v_local_mps + 0.5 * change, normal};
}

Vector3 orca_velocity(std::span<const OrcaPlane> planes, const Vector3& wanted_local_mps, double speed_mps,
                      std::vector<Vector3>& scratch) {
  double relaxation_mps = 0.0;
  for (int i = 0; i < kRelaxations; ++i) {
    const Vector3 v = nearest(planes, wanted_local_mps, speed_mps, relaxation_mps, scratch);
    if (satisfies(planes, v, relaxation_mps)) return v;
    relaxation_mps = relaxation_mps > 0.0 ? kRelaxationFactor * relaxation_mps : kFirstRelaxation_mps;
  }
  return nearest(planes, wanted_local_mps, speed_mps, relaxation_mps, scratch);
}

void OrcaConfig::visit(ConfigVisitor& v) {
  v.field("goal_m", goal_m, "[m] goal in the world frame");
  v.destinations("goal_m", goal_m);
  v.field("arrival_radius_m", arrival_radius_m, "[m] distance to the goal within which the mission is done",
          Range::positive());
  v.field("speed_mps", speed_mps, "[m/s] largest speed", Range::positive());
  v.field("encumbrance_m", encumbrance_m, "[m] radius of the sphere that a vehicle occupies", Range::positive());
  v.field("margin_m", margin_m, "[m] margin added to the sum of the encumbrances", Range::non_negative());
  v.field("z_min_m", z_min_m, "[m] lowest flight level");
  v.field("z_max_m", z_max_m, "[m] highest flight level");
  v.field("planar", planar, "[-] flight at the height of the goal; vehicles avoid each other horizontally");
  v.object("neighbors", neighbors, "source of the neighbors");
  v.object("separation", separation, "separation from neighbors, in addition to the avoidance of the guidance itself");
  v.check(z_max_m > z_min_m, "z_max_m", "more than z_min_m");
}

std::unique_ptr<Guidance> make_orca(const ModuleConfig& config, const GuidanceSetup& setup) {
  const auto& orca = dynamic_cast<const OrcaConfig&>(config);
  return kept_apart(std::make_unique<Orca>(orca, setup), orca.separation, setup, orca.planar);
}

}  // namespace swiftlet
