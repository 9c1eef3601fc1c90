// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/flocking.hpp"

#include <algorithm>
#include <cmath>

#include "core/guidance/flocking/flock_response.hpp"
#include "core/guidance/flocking/rbl_obstacles.hpp"
#include "core/guidance/guidance_constants.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/guidance/kept_apart.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// [m] Height difference above which an obstacle is ignored. Larger values also evade what the vehicle would pass above
/// or below.
constexpr double kLevel_m = 0.6;
/// [m] Distance below which an obstacle repels the vehicle, and a neighbor a vehicle of PACNav. Larger values evade
/// earlier.
constexpr double kObstacle_m = 2.0, kNeighbor_m = 3.0;
/// [m/s] Repulsive speed at half of these distances. Larger values keep more distance.
constexpr double kRepulsion_mps = 1.5;
/// [s] Time span of the remembered paths of neighbors, and time between their points. A longer span follows steadier
/// leaders; shorter steps add noise to the lengths of paths.
constexpr double kMemory_s = 8.0, kSample_s = 0.5;
/// [-] Pixels of the retina around the vehicle. More pixels resolve smaller angles and cost more time.
constexpr std::size_t kRetinaPixels = 360;
/// [cruise speeds] Speed limit of Mezey's model. Smaller values cut the acceleration toward distant neighbors.
constexpr double kMaxSpeed = 2.0;

double wrap(double angle_rad) { return std::remainder(angle_rad, 2.0 * kPi); }

Vector3 horizontal(Vector3 v) {
  v.z() = 0.0;
  return v;
}

/// Repulsive velocity [m/s] from a point, by the displacement from it; 0 beyond reach_m, stronger at smaller distance.
Vector3 repulsion(const Vector3& away, double reach_m) {
  const double d = std::max(away.norm(), kNearest_m);
  if (d >= reach_m) return Vector3::Zero();
  return kRepulsion_mps * (reach_m / d - 1.0) * away / d;
}

/// Repulsive velocity [m/s] from all neighbors nearer than kNeighbor_m.
Vector3 avoidance(const Vector3& p_local_m, std::span<const Neighbor> neighbors) {
  Vector3 push = Vector3::Zero();
  for (const Neighbor& neighbor : neighbors) {
    push += repulsion(horizontal(p_local_m - neighbor.position_local_m), kNeighbor_m);
  }
  return push;
}

/// Common part of both models: flight at constant height, neighbors, and repulsion from obstacles.
class LevelFlight : public Guidance {
 public:
  GuidanceNeeds needs() const override { return {.map = lidar_.enabled}; }

 protected:
  LevelFlight(const NeighborSourceConfig& neighbors, const FlockObstacleConfig& lidar, const GuidanceSetup& setup)
      : neighbors_(neighbors), lidar_(lidar) {
    goal_.position_m = setup.agent.T_local_body_start.translation();
    goal_.yaw_rad = yaw_of(setup.agent.T_local_body_start.linear());
    height_m_ = goal_.position_m.z();
  }

  /// Updates neighbors and the nearest obstacle from the tick's input.
  void look(const GuidanceInput& input) {
    neighbors_.update(input);
    if (lidar_.enabled && input.observation.t >= next_look_) find_obstacle(input);
  }

  /// Repulsive velocity [m/s] from the nearest obstacle.
  Vector3 off_obstacle(const Vector3& p_local_m) const {
    if (!obstacle_) return Vector3::Zero();
    return repulsion(horizontal(p_local_m - obstacle_m_), kObstacle_m);
  }

  void fly(const Vector3& p_local_m, const Vector3& v_mps, double speed_mps, GuidanceOutput& output) {
    goal_.position_m = p_local_m + kGoalAhead_s * v_mps;
    goal_.position_m.z() = height_m_;
    output.goal = goal_;
    output.speed_limit_mps = speed_mps;
  }

  NeighborMemory neighbors_;
  Reference goal_;
  double height_m_ = 0.0;
  bool arrived_ = false;

 private:
  void find_obstacle(const GuidanceInput& input) {
    next_look_ = input.observation.t + from_seconds(kUpdatePeriod_s);
    const Vector3 p_local_m = input.estimate.T_local_body.translation();
    const double edge_m = input.map->edge_m();
    input.map->occupied_within(p_local_m, kObstacle_m, kEver, voxels_m_);
    obstacle_ = false;
    double least_m = kObstacle_m;
    for (const Vector3& voxel_m : voxels_m_) {
      if (std::abs(voxel_m.z() - p_local_m.z()) > kLevel_m) continue;
      const Vector3 nearest_m = nearest_in_voxel(p_local_m, voxel_m, edge_m);
      const double d = horizontal(p_local_m - nearest_m).norm();
      if (d >= least_m) continue;
      least_m = d;
      obstacle_m_ = nearest_m;
      obstacle_ = true;
    }
  }

  FlockObstacleConfig lidar_;
  std::vector<Vector3> voxels_m_;
  Vector3 obstacle_m_ = Vector3::Zero();
  bool obstacle_ = false;
  TimeNs next_look_ = 0;
};

/// Positions of one neighbor over the last seconds, oldest first.
struct RememberedPath {
  std::int64_t key = 0;
  std::vector<Vector3> points_local_m;
  TimeNs last = 0;
};

/// Mean cosine [-] between the displacement of one path and those of the others; 0 without others.
double similarity(const RememberedPath& path, std::span<const RememberedPath> all) {
  const Vector3 direction = horizontal(path.points_local_m.back() - path.points_local_m.front());
  double sum = 0.0;
  int count = 0;
  for (const RememberedPath& other : all) {
    if (other.key == path.key || other.points_local_m.size() < 2) continue;
    const Vector3 with = horizontal(other.points_local_m.back() - other.points_local_m.front());
    const double lengths = direction.norm() * with.norm();
    if (lengths < kNearest_m) continue;
    sum += direction.dot(with) / lengths;
    ++count;
  }
  return count > 0 ? sum / count : 0.0;
}

class Pacnav : public LevelFlight {
 public:
  Pacnav(const PacnavConfig& config, const GuidanceSetup& setup)
      : LevelFlight(config.neighbors, config.lidar, setup), config_(config) {}

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox&) override {
    look(input);
    remember(input.observation.t);
    const Vector3 p_local_m = input.estimate.T_local_body.translation();
    const Vector3 goal_local_m = FrameChange::to_local(input.estimate).point(config_.goal_m);
    const double to_goal_m = horizontal(goal_local_m - p_local_m).norm();
    const double radius_m = config_.informed ? config_.arrival_radius_m : 2.0 * config_.follow_radius_m;
    arrived_ = arrived_ || to_goal_m <= radius_m;
    Vector3 v = toward(p_local_m, aim(p_local_m, goal_local_m));
    v += avoidance(p_local_m, neighbors_.neighbors());
    v += off_obstacle(p_local_m);
    if (v.norm() > config_.speed_mps) v *= config_.speed_mps / v.norm();
    fly(p_local_m, v, config_.speed_mps, output);
    output.mission = arrived_ ? MissionStatus::kDone : MissionStatus::kRunning;
  }

 private:
  Vector3 toward(const Vector3& p_local_m, const Vector3& aim_local_m) const {
    const Vector3 offset = horizontal(aim_local_m - p_local_m);
    const double d = offset.norm();
    return d > kNearest_m ? Vector3(offset / d * std::min(config_.speed_mps, d / kGoalAhead_s))
                          : Vector3(Vector3::Zero());
  }

  /// Point to fly to: the goal of an informed vehicle, otherwise a point at follow_radius_m from the neighbor with the
  /// most persistent and most similar path; the own position if no path qualifies.
  Vector3 aim(const Vector3& p_local_m, const Vector3& goal_local_m) const {
    if (config_.informed) return goal_local_m;
    double best = 0.0;
    const RememberedPath* leader = nullptr;
    for (const RememberedPath& path : paths_) {
      if (path.points_local_m.size() < 3) continue;  // two points are straight in any case
      const double persistence = path_persistence(path.points_local_m);
      const double score = persistence * (1.0 + std::max(0.0, similarity(path, paths_)));
      if (persistence < config_.least_persistence || score <= best) continue;
      best = score;
      leader = &path;
    }
    if (leader == nullptr) return p_local_m;
    const Vector3 behind = horizontal(p_local_m - leader->points_local_m.back());
    const double d = behind.norm();
    return d <= config_.follow_radius_m ? p_local_m
                                        : Vector3(leader->points_local_m.back() + behind / d * config_.follow_radius_m);
  }

  void remember(TimeNs now) {
    const auto most = static_cast<std::size_t>(kMemory_s / kSample_s) + 1;
    for (const Neighbor& neighbor : neighbors_.neighbors()) {
      auto path =
          std::find_if(paths_.begin(), paths_.end(), [&](const RememberedPath& p) { return p.key == neighbor.key; });
      if (path == paths_.end()) path = paths_.insert(paths_.end(), {neighbor.key, {}, 0});
      if (!path->points_local_m.empty() && now - path->last < from_seconds(kSample_s)) continue;
      if (path->points_local_m.size() >= most) path->points_local_m.erase(path->points_local_m.begin());
      path->points_local_m.push_back(neighbor.position_local_m);
      path->last = now;
    }
    std::erase_if(paths_, [&](const RememberedPath& p) { return now - p.last > from_seconds(kMemory_s); });
  }

  PacnavConfig config_;
  std::vector<RememberedPath> paths_;
};

class Mezey : public LevelFlight {
 public:
  Mezey(const MezeyConfig& config, const GuidanceSetup& setup)
      : LevelFlight(config.neighbors, config.lidar, setup), config_(config), heading_rad_(goal_.yaw_rad) {}

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox&) override {
    look(input);
    const Vector3 p_local_m = input.estimate.T_local_body.translation();
    const Vector3 to_goal = horizontal(FrameChange::to_local(input.estimate).point(config_.goal_m) - p_local_m);
    arrived_ = arrived_ || (config_.goal_weight_radps > 0.0 && to_goal.norm() <= config_.arrival_radius_m);
    const VisualResponse seen = visual_response(config_, p_local_m, heading_rad_, neighbors_.neighbors(), retina_);
    double turn = seen.turn_radps;
    if (to_goal.norm() > kNearest_m) {
      turn += config_.goal_weight_radps * elementary::sin(elementary::atan2(to_goal.y(), to_goal.x()) - heading_rad_);
    }
    speed_mps_ +=
        input.dt_s * (config_.relaxation_radps * (config_.cruise_speed_mps - speed_mps_) + seen.acceleration_mps2);
    speed_mps_ = std::clamp(speed_mps_, 0.0, kMaxSpeed * config_.cruise_speed_mps);
    heading_rad_ = wrap(heading_rad_ + input.dt_s * turn);
    const double v = arrived_ ? 0.0 : speed_mps_;
    goal_.yaw_rad = heading_rad_;
    fly(p_local_m,
        v * Vector3(elementary::cos(heading_rad_), elementary::sin(heading_rad_), 0.0) + off_obstacle(p_local_m),
        kMaxSpeed * config_.cruise_speed_mps, output);
    output.mission = arrived_                          ? MissionStatus::kDone
                     : config_.goal_weight_radps > 0.0 ? MissionStatus::kRunning
                                                       : MissionStatus::kEndless;
  }

 private:
  MezeyConfig config_;
  std::vector<char> retina_ = std::vector<char>(kRetinaPixels);
  double heading_rad_ = 0.0, speed_mps_ = 0.0;
};

}  // namespace

double path_persistence(std::span<const Vector3> path_local_m) {
  double length_m = 0.0;
  for (std::size_t i = 1; i < path_local_m.size(); ++i) length_m += (path_local_m[i] - path_local_m[i - 1]).norm();
  return length_m > kNearest_m ? (path_local_m.back() - path_local_m.front()).norm() / length_m : 0.0;
}

VisualResponse visual_response(const MezeyConfig& config, const Vector3& p_local_m, double heading_rad,
                               std::span<const Neighbor> neighbors, std::vector<char>& retina) {
  const int n = static_cast<int>(retina.size());
  std::fill(retina.begin(), retina.end(), 0);
  const double pixel = 2.0 * kPi / n;
  for (const Neighbor& neighbor : neighbors) {
    const Vector3 offset = horizontal(neighbor.position_local_m - p_local_m);
    const double d = offset.norm();
    const double half = d > config.body_radius_m ? elementary::asin(config.body_radius_m / d) : kPi / 2.0;
    const double bearing = wrap(elementary::atan2(offset.y(), offset.x()) - heading_rad);
    const int first = static_cast<int>(std::floor((bearing - half + kPi) / pixel));
    const int last = static_cast<int>(std::floor((bearing + half + kPi) / pixel));
    for (int i = first; i <= last; ++i) retina[static_cast<std::size_t>(((i % n) + n) % n)] = 1;
  }
  // Covered pixels repel, edges attract: near neighbors cover many pixels, far ones are all edge.
  VisualResponse response;
  for (int i = 0; i < n; ++i) {
    const double phi = -kPi + (i + 0.5) * pixel;
    const bool edge = retina[i] != retina[(i + 1) % n];
    const double seen = retina[i] != 0 ? pixel : 0.0;
    const double phi_edge = -kPi + (i + 1.0) * pixel;
    response.acceleration_mps2 +=
        config.alpha0 * (-elementary::cos(phi) * seen + (edge ? config.alpha1 * elementary::cos(phi_edge) : 0.0));
    response.turn_radps +=
        config.beta0 * (-elementary::sin(phi) * seen + (edge ? config.beta1 * elementary::sin(phi_edge) : 0.0));
  }
  return response;
}

void FlockObstacleConfig::visit(ConfigVisitor& v) {
  v.field("enabled", enabled, "[-] whether the vehicle avoids obstacles in its map (mapping)");
}

void PacnavConfig::visit(ConfigVisitor& v) {
  v.field("informed", informed,
          "[-] whether the vehicle flies to the goal; if not, it follows the neighbor with the straightest path");
  v.field("goal_m", goal_m, "[m] goal in the world frame; only x and y are used");
  v.field("arrival_radius_m", arrival_radius_m,
          "[m] horizontal distance to the goal within which the mission of an informed vehicle is done",
          Range::positive());
  v.field("follow_radius_m", follow_radius_m,
          "[m] uninformed: distance kept to the followed neighbor; the mission is done within twice this distance of "
          "the goal",
          Range::positive());
  v.field("speed_mps", speed_mps, "[m/s] largest speed", Range::positive());
  v.field("least_persistence", least_persistence,
          "[-] minimum persistence (displacement over length) of a path that is followed", Range::probability());
  v.object("neighbors", neighbors, "source of the neighbors");
  v.object("lidar", lidar, "avoidance of obstacles");
  v.object("separation", separation, "separation from neighbors, in addition to the avoidance of the guidance itself");
}

void MezeyConfig::visit(ConfigVisitor& v) {
  v.field("goal_m", goal_m, "[m] goal in the world frame; only x and y are used");
  v.field("goal_weight_radps", goal_weight_radps, "[rad/s] largest turn rate toward the goal; 0: none, as published",
          Range::non_negative());
  v.field("arrival_radius_m", arrival_radius_m, "[m] horizontal distance to the goal within which the mission is done",
          Range::positive());
  v.field("cruise_speed_mps", cruise_speed_mps, "[m/s] v_0: speed without neighbors", Range::positive());
  v.field("relaxation_radps", relaxation_radps, "[1/s] gamma: rate of the return to the cruise speed",
          Range::positive());
  v.field("alpha0", alpha0, "[m/s^2] alpha_0: gain of the acceleration per radian of covered retina",
          Range::non_negative());
  v.field("alpha1", alpha1,
          "[-] alpha_1: weight of edges in the acceleration; larger values keep vehicles closer together",
          Range::non_negative());
  v.field("beta0", beta0, "[rad/s] beta_0: gain of the turn rate per radian of covered retina", Range::non_negative());
  v.field("beta1", beta1, "[-] beta_1: weight of edges in the turn rate", Range::non_negative());
  v.field("body_radius_m", body_radius_m, "[m] radius of a neighbor in the projection on the retina",
          Range::positive());
  v.object("neighbors", neighbors, "source of the neighbors");
  v.object("lidar", lidar, "avoidance of obstacles");
}

std::unique_ptr<Guidance> make_pacnav(const ModuleConfig& config, const GuidanceSetup& setup) {
  const auto& pacnav = dynamic_cast<const PacnavConfig&>(config);
  return kept_apart(std::make_unique<Pacnav>(pacnav, setup), pacnav.separation, setup, true);
}

std::unique_ptr<Guidance> make_mezey(const ModuleConfig& config, const GuidanceSetup& setup) {
  return std::make_unique<Mezey>(dynamic_cast<const MezeyConfig&>(config), setup);
}

}  // namespace swiftlet
