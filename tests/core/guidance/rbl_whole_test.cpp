// SPDX-License-Identifier: BSD-3-Clause
// The rule-based Lloyd algorithm as a whole, beside the order in which its parts are asked; and its pictures.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/guidance/rbl_sight.hpp"
#include "swiftlet/core/guidance/rbl.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/math/random.hpp"
#include "tests/core/guidance/guidance_driver.hpp"

namespace swiftlet {
namespace {

using testing::GuidanceDriver;
using testing::ToldMap;
using Whole = RblConfig::Variant;

/// Every third cell was hit long ago.
struct AgingMap : ToldMap {
  explicit AgingMap(const std::vector<Vector3>& cells_m) : ToldMap(cells_m) {}
  void occupied_within(const Vector3& center_m, double radius_m, TimeNs since,
                       std::vector<Vector3>& found_m) const override {
    ToldMap::occupied_within(center_m, radius_m, since, found_m);
    const TimeNs old = 2 * kNsPerSecond + kNsPerSecond / 2;
    std::erase_if(found_m, [&](const Vector3& p_m) {
      return since != kEver && since > old && static_cast<int>(std::floor(10.0 * p_m.x())) % 3 == 0;
    });
  }
};

class PlainRbl {
 public:
  PlainRbl(const RblConfig& config, const AgentSetup& agent)
      : c_(config),
        planar_(config.variant == Whole::k2d),
        memory_(config.neighbors, agent.neighbor_views),
        planner_(config.cells, rules_for(config), planar_),
        sensed_(config.cells.sensing_radius_m, config.cells.step_m, planar_),
        limits_(config.separation.enabled ? config.separation.within(MotionLimits{}) : MotionLimits{}),
        reference_(limits_, planar_),
        settling_(config.settle_s),
        sight_(agent.neighbor_views),
        viewed_(2.0 * config.cells.sensing_radius_m, config.cells.encumbrance_m) {
    goal_.position_m = agent.T_local_body_start.translation();
    goal_.yaw_rad = yaw_of(agent.T_local_body_start.linear());
  }

  void tick(const GuidanceInput& in) {
    T_ = in.estimate.T_local_body;
    p_m_ = T_.translation();
    v_mps_ = in.estimate.v_local_mps;
    now_ = in.observation.t;
    map_ = in.map;
    const FrameChange to_local = FrameChange::to_local(in.estimate);
    goal_m_ = to_local.point(c_.goal_m);
    const bool limited = c_.variant == Whole::k3dClipped || c_.variant == Whole::k3dZ;
    low_m_ = to_local.height(limited ? c_.z_min_m : c_.ground_m + c_.cells.encumbrance_m);
    high_m_ = to_local.height(c_.z_max_m);
    if (planar_) high_m_ = std::max(high_m_, goal_m_.z());
    if (c_.variant == Whole::k3d) high_m_ = std::numeric_limits<double>::infinity();
    memory_.update(in);
    if (first_) {
      started_ = now_;
      Reference here;
      here.position_m = p_m_;
      here.velocity_mps = in.estimate.v_local_mps;
      here.yaw_rad = yaw_of(T_.linear());
      reference_.reset(here);
    }
    const TimeNs period = from_seconds(1.0 / c_.update_rate_hz);
    if (first_ || now_ >= next_) {
      next_ = first_ ? now_ + period : next_ + period;
      plan();
    }
    first_ = false;
    const double off_m = planar_ ? (goal_m_ - p_m_).head<2>().norm() : (goal_m_ - p_m_).norm();
    arrived = arrived || off_m <= c_.arrival_radius_m;
    // From one centroid to the next, unless each tick brings one.
    const double gone = 1.0 - to_seconds(next_ - now_) * c_.update_rate_hz;
    const double share = from_seconds(in.dt_s) >= period ? 1.0 : std::clamp(gone, 0.0, 1.0);
    goal_.position_m = from_m_ + share * (to_m_ - from_m_);
    goal = c_.separation.enabled ? reference_.step(goal_, in.dt_s, c_.speed_mps) : goal_;
  }

  bool arrived = false, pressed = false;
  int num_pressed_by_lidar = 0;
  int num_waits = 0, num_looks_around = 0, num_pressed = 0, num_dodged = 0, num_turned_away = 0, num_out_of_plane = 0;
  RblStatus status;
  Reference goal;

 private:
  static RblRules rules_for(const RblConfig& config) {
    RblRules rules = config.rules;
    if (config.variant != Whole::k3dZ) rules.elevation_rule = false;
    return rules;
  }
  Vector3 flat(const Vector3& v) const { return planar_ ? Vector3(v.x(), v.y(), 0.0) : v; }

  void plan() {
    std::vector<Vector3> others_m;
    for (const Neighbor& other : memory_.neighbors()) others_m.push_back(other.position_local_m);
    planner_.partition(p_m_, others_m, low_m_, high_m_);
    if (c_.separation.enabled) keep_from_others(c_.separation.sigmas);
    if (c_.separation.enabled && planner_.cell().is_empty()) {  // doubt holds nobody who has to make way
      planner_.partition(p_m_, others_m, low_m_, high_m_);
      keep_from_others(0.0);
    }
    walls_.clear();
    if (c_.lidar.enabled) {
      if (c_.separation.enabled) planner_.harden();
      const std::size_t num_others = planner_.cuts().size();
      keep_from_voxels(planner_.cell(), planner_.cuts(), kEver);
      // Who gives way, or has no cell left, needs planes.
      if (c_.separation.enabled && c_.lidar.cut == RblLidarConfig::Cut::kNearest &&
          (pressed || planner_.cell().is_empty()))
        cutter_.convex_planes(p_m_, voxels_m_, map_->edge_m(), c_.cells.encumbrance_m, c_.cells.eta, planner_.cuts());
      for (std::size_t i = num_others; i < planner_.cuts().size(); ++i) walls_.push_back(planner_.cuts()[i]);
      viewed_.look(p_m_, yaw_of(T_.linear()), field_of_view(T_.linear(), c_.lidar.fov_lower_deg, c_.lidar.fov_deg));
    }
    centroid_m_ = planner_.update(goal_m_, 1.0 / c_.update_rate_hz).centroid_local_m;
    from_m_ = goal_.position_m;
    to_m_ = c_.lidar.enabled && !pressed ? in_sight() : centroid_m_;
    if (c_.lidar.enabled && pressed && (centroid_m_ - p_m_).head<2>().norm() >= 0.3)
      goal_.yaw_rad = std::atan2(centroid_m_.y() - p_m_.y(), centroid_m_.x() - p_m_.x());
    if (c_.separation.enabled) {
      if (!c_.lidar.enabled) {
        goal_.yaw_rad = sight_.heading(T_, to_m_, memory_.neighbors(), coming_m_, goal_.yaw_rad, now_);
        if (!pressed && !sight_.sees_ahead(T_, to_m_)) {
          ++num_waits;
          to_m_ = reference_.rest_local_m();
        }
      }
      // Until twice the longest interval between samples has passed, when that is a long one.
      const double seldom_s = memory_.longest_s();
      if (!pressed && seldom_s > 0.5 && to_seconds(now_ - started_) < 2.0 * seldom_s) {
        ++num_looks_around;
        to_m_ = reference_.rest_local_m();
      }
      if (pressed) {
        const Vector3 aside_m = to_m_ - p_m_;
        double times = 3.0;
        if (c_.lidar.enabled) {  // no farther than it senses, and into nothing
          num_pressed_by_lidar += 1;
          times = std::min(times, c_.cells.sensing_radius_m / aside_m.norm());
          for (const HalfSpace& wall : walls_) {
            if (wall.normal_local.dot(aside_m) > 0.0)
              times = std::min(times, wall.offset_m / wall.normal_local.dot(aside_m));
          }
          planes_.insert(planes_.end(), walls_.begin(), walls_.end());
        }
        to_m_ = p_m_ + std::max(times, 1.0) * aside_m;
        if (to_m_.z() < p_m_.z()) to_m_.z() = std::max(to_m_.z(), std::min(low_m_, p_m_.z()));
        if (to_m_.z() > p_m_.z()) to_m_.z() = std::min(to_m_.z(), std::max(high_m_, p_m_.z()));
      }
      num_pressed += pressed;
      to_m_ = reference_.admit(from_m_, to_m_, planes_, p_m_, 1.0 / c_.update_rate_hz, c_.speed_mps);
    }
    if (planar_) to_m_.z() = height_m();
    status = settling_.update({.p_local_m = goal_m_,
                               .z_min_m = low_m_,
                               .z_max_m = high_m_,
                               .reach_m = c_.cells.sensing_radius_m,
                               .encumbrance_m = c_.cells.encumbrance_m,
                               .apart_m = 2.0 * c_.cells.encumbrance_m + c_.separation.margin_m,
                               .planar = planar_},
                              p_m_, memory_.neighbors(), c_.lidar.enabled ? map_ : nullptr, now_);
  }

  /// In a plane: above or below the last one who came and did not brake, for one and a half seconds.
  double height_m() {
    if (!c_.separation.enabled || came_ < 0 || now_ - came_ > 1'500'000'000) {
      side_ = 0;
      return goal_m_.z();
    }
    const double above_m = came_m_ + c_.separation.vertical_m, below_m = came_m_ - c_.separation.vertical_m;
    if (side_ == 0) side_ = p_m_.z() >= came_m_ - 0.3 ? 1 : -1;
    if (side_ > 0 && above_m > high_m_ && below_m >= low_m_) side_ = -1;
    if (side_ < 0 && below_m < low_m_ && above_m <= high_m_) side_ = 1;
    ++num_out_of_plane;
    double wanted_m = side_ > 0 ? std::max(goal_m_.z(), above_m) : std::min(goal_m_.z(), below_m);
    if (wanted_m < goal_m_.z()) wanted_m = std::max(wanted_m, std::min(low_m_, goal_m_.z()));
    if (wanted_m > goal_m_.z()) wanted_m = std::min(wanted_m, std::max(high_m_, goal_m_.z()));
    if (!c_.lidar.enabled) return wanted_m;
    // By steps of 0.2 m, while there is room and it has seen the air.
    const double enc_m = c_.cells.encumbrance_m, way = wanted_m >= p_m_.z() ? 1.0 : -1.0;
    double z_m = p_m_.z();
    while (z_m != wanted_m) {
      const double next_m = std::abs(wanted_m - z_m) <= 0.2 ? wanted_m : z_m + 0.2 * way;
      const Vector3 q_m(p_m_.x(), p_m_.y(), next_m);
      if (map_->distance_m(q_m, enc_m) < enc_m || !viewed_.contains(q_m + way * enc_m * Vector3::UnitZ(), *map_)) break;
      z_m = next_m;
    }
    return z_m;
  }

  /// Planes halfway between the ways on which both brake, nearer by what is unsure along the line between them.
  void keep_from_others(double sigmas) {
    const double apart_m = 2.0 * c_.cells.encumbrance_m + c_.separation.margin_m;
    const double late_s = c_.separation.reaction_s + 1.0 / c_.update_rate_hz;
    planes_.clear();
    coming_m_.clear();
    pressed = false;
    double nearest_m = 1e9;
    for (const Neighbor& other : memory_.neighbors()) {
      const Vector3 its_m = flat(other.position_local_m), its_mps = flat(other.velocity_local_mps);
      const Vector3 along = (its_m - flat(p_m_)).normalized();
      const double comes_mps = std::max(0.0, -along.dot(its_mps));
      const double unsure_m = std::sqrt(along.dot(other.covariance_local_m2 * along)) +
                              (late_s + comes_mps / limits_.horizontal_acceleration_mps2) *
                                  std::sqrt(along.dot(other.velocity_covariance_local_m2ps2 * along));
      const Braking self{flat(p_m_), flat(reference_.rest_local_m())};
      const double above_m = planar_ ? apart_m : c_.separation.vertical_m;
      const HalfSpace plane = braking_cut(self, braking_of(its_m, its_mps, late_s + other.unpredicted_s, limits_),
                                          apart_m, above_m, sigmas * unsure_m);
      // Of one unseen for five seconds, doubt leaves a meter of the cell.
      const HalfSpace sure =
          braking_cut(self, braking_of(its_m, its_mps, late_s + other.unpredicted_s, limits_), apart_m, above_m, 0.0);
      const bool gone = now_ - other.seen > 5 * kNsPerSecond;
      stay_behind(plane, gone ? std::max(plane.offset_m, std::min(sure.offset_m, 1.0)) : plane.offset_m);
      // Two that meet within three seconds look at each other.
      const double meet_mps = along.dot(flat(v_mps_) - its_mps);
      if (meet_mps > 0.5 && (its_m - flat(p_m_)).norm() < apart_m + 3.0 * meet_mps) coming_m_.push_back(its_m);
      // Half a second before the own half of the room is used up by one that comes faster than 0.5 m/s, as far as is
      // known, and half a standard deviation faster than it seems.
      const double unsure_mps = std::sqrt(along.dot(other.velocity_covariance_local_m2ps2 * along));
      if (comes_mps <= 0.5 || comes_mps <= 0.5 * unsure_mps) continue;
      const double fast = 1.0 + 0.5 * unsure_mps / comes_mps;
      const Braking hasty = braking_of(its_m, fast * its_mps, late_s + other.unpredicted_s, limits_);
      if (braking_cut(self, hasty, apart_m, above_m, 0.0).offset_m >= 0.25 * fast * comes_mps) continue;
      if ((its_m - flat(p_m_)).norm() < nearest_m) {
        nearest_m = (its_m - flat(p_m_)).norm();
        came_ = now_;
        came_m_ = other.position_local_m.z();
      }
      // One standard deviation beside the level way when it is here, up to half a meter.
      Vector3 across(-its_mps.y(), its_mps.x(), 0.0);
      double wider_m = 0.0;
      if (across.norm() >= 0.5) {
        across.normalize();
        const double in_s = (its_m - flat(p_m_)).norm() / comes_mps;
        wider_m = std::min(
            0.5, std::sqrt(across.dot(
                     (other.covariance_local_m2 + in_s * in_s * other.velocity_covariance_local_m2ps2) * across)));
      }
      // To the side of the last one and a half seconds.
      const auto last = begun_.find(other.key);
      const bool goes_on = last != begun_.end() && now_ - last->second.first <= 1'500'000'000;
      const auto beside = dodging_cut(self, its_m, its_mps, apart_m + wider_m, above_m * (1.0 + wider_m / apart_m),
                                      limits_, goes_on ? &last->second.second : nullptr);
      if (!beside) continue;
      begun_[other.key] = {now_, beside->normal_local};
      ++num_dodged;
      stay_behind(*beside, beside->offset_m);
    }
    for (const HalfSpace& plane : planes_) {
      if (pressed) planner_.cell().cut(plane);
    }
  }

  void stay_behind(const HalfSpace& plane, double cell_offset_m) {
    if (plane.offset_m < -0.01) pressed = true;
    planes_.push_back(plane);
    if (cell_offset_m >= c_.cells.sensing_radius_m) return;
    planner_.cuts().push_back({plane.normal_local, cell_offset_m});
    planner_.cell().cut(planner_.cuts().back());
  }

  void keep_from_voxels(RblCell& cell, std::vector<HalfSpace>& cuts, TimeNs since) {
    std::vector<Vector3>& voxels_m = voxels_m_;
    const double enc_m = c_.cells.encumbrance_m, edge_m = map_->edge_m();
    map_->occupied_within(p_m_, c_.cells.sensing_radius_m / c_.cells.eta + enc_m, since, voxels_m);
    // What it can never come near to, deep below.
    std::erase_if(voxels_m,
                  [&](const Vector3& v_m) { return v_m.z() + 0.5 * edge_m + enc_m < std::min(low_m_, p_m_.z()); });
    if (c_.lidar.cut == RblLidarConfig::Cut::kConvex)
      cutter_.cut_convex(cell, p_m_, voxels_m, edge_m, enc_m, c_.cells.eta, cuts);
    else
      cutter_.cut_nearest(cell, p_m_, voxels_m, edge_m, enc_m, c_.cells.eta);
  }

  Vector3 in_sight() {
    const Vector3 to_m = centroid_m_ - p_m_;
    if (to_m.head<2>().norm() >= 0.3) goal_.yaw_rad = std::atan2(to_m.y(), to_m.x());
    if ((goal_m_ - p_m_).norm() <= c_.cells.encumbrance_m) return centroid_m_;
    sensed_.reset(Vector3::Zero(), low_m_ - p_m_.z(), high_m_ - p_m_.z());
    for (const HalfSpace& side : field_of_view(T_.linear(), c_.lidar.fov_lower_deg, c_.lidar.fov_deg))
      sensed_.cut(side);
    std::vector<HalfSpace> cuts;
    keep_from_voxels(sensed_, cuts, now_ - from_seconds(c_.lidar.sensed_s));
    const int nearest = sensed_.nearest_partitioned(to_m);
    const double off_deg = std::remainder(goal_.yaw_rad - yaw_of(T_.linear()), 2.0 * kPi) * 180.0 / kPi;
    if (nearest >= 0 && std::abs(off_deg) > c_.lidar.facing_deg) {
      ++num_turned_away;
      return p_m_;
    }
    // Half of the diagonal between samples away is as good as seen.
    const Vector3 seen_m = nearest < 0 ? Vector3(Vector3::Zero()) : sensed_.point(nearest);
    if (nearest >= 0 && (seen_m - to_m).norm() <= 0.87 * c_.cells.step_m) return p_m_ + to_m;
    // Near the goal by 0.2 m at a time, where it knows the air in front of its hull.
    const bool near = (goal_m_ - p_m_).norm() <= c_.cells.sensing_radius_m;
    const Vector3 front_m = p_m_ + (std::min(0.2, to_m.norm()) + c_.cells.encumbrance_m) * to_m.normalized();
    if (c_.separation.enabled && near && viewed_.contains(front_m, *map_))
      return p_m_ + std::min(0.2, to_m.norm()) * to_m.normalized();
    return p_m_ + seen_m;
  }

  RblConfig c_;
  bool planar_, first_ = true;
  NeighborMemory memory_;
  RblPlanner planner_;
  RblCell sensed_;
  ObstacleCutter cutter_;
  MotionLimits limits_;
  GuardedReference reference_;
  RblSettling settling_;
  RblSight sight_;
  RblViewed viewed_;
  std::vector<Vector3> voxels_m_;
  std::vector<HalfSpace> planes_, walls_;
  std::vector<Vector3> coming_m_;
  Pose T_ = Pose::Identity();
  Vector3 p_m_, v_mps_, goal_m_, centroid_m_, from_m_ = Vector3::Zero(), to_m_ = Vector3::Zero();
  double low_m_ = 0.0, high_m_ = 0.0;
  double came_m_ = 0.0;  // height of the last one who came and did not brake
  TimeNs came_ = -1;
  std::map<std::int64_t, std::pair<TimeNs, Vector3>> begun_;  // when and behind which plane it stepped aside
  int side_ = 0;                                              // of its height
  TimeNs now_ = 0, next_ = 0, started_ = 0;
  const OccupancyView* map_ = nullptr;
  Reference goal_;
};

TEST(RblWhole, EveryGoalIsWhatItsPartsSayInTurn) {
  int pressed_by_lidar = 0;
  int waits = 0, looks_around = 0, pressed = 0, dodged = 0, out_of_plane = 0, turned_away = 0, arrived = 0;
  for (std::uint32_t round = 0; round < 24; ++round) {
    const Random random(round, "test.rbl-whole");
    std::uint32_t index = 0;
    const auto draw = [&](double min, double max) { return random.uniform(min, max, 0, index++); };
    RblConfig config;
    config.variant = static_cast<Whole>(round % 4);
    config.separation.enabled = round % 8 < 5;
    config.separation.pledge_share = 0.0;  // pledges and detours have tests of their own
    config.detour.enabled = false;
    config.lidar.enabled = round % 3 == 0;
    config.lidar.cut = round % 2 == 0 ? RblLidarConfig::Cut::kConvex : RblLidarConfig::Cut::kNearest;
    config.lidar.facing_deg = draw(20.0, 120.0);
    config.goal_m = {draw(-6.0, 6.0), draw(-6.0, 6.0), draw(1.0, 6.0)};
    config.update_rate_hz = round % 5 == 4 ? 30.0 : draw(3.0, 12.0);
    config.arrival_radius_m = 0.4;
    config.settle_s = draw(0.4, 2.0);
    config.speed_mps = draw(1.0, 4.0);
    config.ground_m = draw(0.0, 1.5);
    config.z_min_m = draw(1.0, 3.0);
    config.z_max_m = draw(4.0, 7.0);
    config.cells.sensing_radius_m = 2.5;
    config.cells.step_m = 0.4;
    config.cells.encumbrance_m = draw(0.3, 0.6);
    config.separation.margin_m = draw(0.0, 0.3);
    config.separation.sigmas = draw(0.5, 3.0);
    config.separation.vertical_m = draw(0.8, 2.0);
    config.separation.reaction_s = draw(0.05, 0.4);
    config.separation.acceleration_mps2 = draw(1.0, 3.0);
    config.separation.jerk_mps3 = draw(8.0, 30.0);
    const Vector3 start_m(draw(-4.0, 4.0), draw(-4.0, 4.0), draw(1.5, 4.0));
    GuidanceDriver driver("rbl", config, start_m, draw(-3.0, 3.0));
    if (round % 2 == 1) {
      NeighborView view;
      view.cones.push_back({Vector3::UnitX(), std::cos(draw(0.5, 1.4))});
      driver.setup.neighbor_views = {view};
      driver.make("rbl", config);
    }
    if (round % 7 == 3) driver.estimate.correct(level_alignment(0.4, {0.5, -0.5, 0.3}, Vector3::Zero()));
    driver.estimate.v_local_mps = {0.3, 0.1, 0.0};
    driver.dt_s = 0.04;
    std::vector<Vector3> cells_m;
    for (int i = 0; i < 25; ++i) cells_m.emplace_back(draw(-5.0, 5.0), draw(-5.0, 5.0), draw(0.0, 5.0));
    const AgingMap map(cells_m);
    driver.map = &map;
    PlainRbl plain(config, driver.setup);
    std::vector<Vector3> others_m, v_mps;
    for (int i = 0; i < 3; ++i) {
      others_m.emplace_back(draw(-4.0, 4.0), draw(-4.0, 4.0), draw(1.5, 4.0));
      v_mps.emplace_back(draw(-0.8, 0.8), draw(-0.8, 0.8), draw(-0.2, 0.2));
    }
    for (std::uint32_t tick = 1; tick <= 110; ++tick) {
      for (std::size_t i = 0; i < others_m.size(); ++i) {
        others_m[i] += driver.dt_s * v_mps[i];
        const auto id = static_cast<std::uint32_t>(i);
        if (random.uniform(tick / 25, 500 + id) < 0.4) continue;  // out of sight
        driver.sees(static_cast<VehicleId>(i) + 1, others_m[i]);
        driver.observation.neighbors.back().covariance_body = Vector3(0.01, 0.03, 0.02).asDiagonal();
      }
      Observation seen = driver.observation;
      driver.step();
      seen.t = driver.observation.t;
      plain.tick(
          {.dt_s = driver.dt_s, .estimate = driver.estimate, .observation = seen, .poses = driver.poses, .map = &map});
      ASSERT_LT((driver.out.goal.position_m - plain.goal.position_m).norm(), 1e-7) << round << ", " << tick;
      ASSERT_NEAR(std::remainder(driver.out.goal.yaw_rad - plain.goal.yaw_rad, 2.0 * kPi), 0.0, 1e-7) << round;
      ASSERT_EQ(driver.out.goal_is_feasible, config.separation.enabled);
      ASSERT_EQ(driver.out.speed_limit_mps, config.speed_mps);
      ASSERT_EQ(driver.out.mission, plain.arrived ? MissionStatus::kDone : plain.status.mission);
      ASSERT_EQ(std::string(driver.out.note), plain.arrived ? "" : plain.status.note);
      const Vector3 way_m = driver.out.goal.position_m - driver.p_m();
      const double part = config.separation.enabled ? 1.0 : std::min(1.0, 0.08 / std::max(way_m.norm(), 1e-9));
      driver.estimate.v_local_mps = part / driver.dt_s * way_m;
      driver.put(driver.p_m() + part * way_m, driver.out.goal.yaw_rad);
    }
    waits += plain.num_waits;
    looks_around += plain.num_looks_around;
    pressed += plain.num_pressed;
    pressed_by_lidar += plain.num_pressed_by_lidar;
    dodged += plain.num_dodged;
    out_of_plane += plain.num_out_of_plane;
    turned_away += plain.num_turned_away;
    arrived += plain.arrived;
  }
  EXPECT_GT(waits, 5);
  EXPECT_GT(looks_around, 5);
  EXPECT_GT(pressed, 5);
  EXPECT_GT(pressed_by_lidar, 5);
  EXPECT_GT(dodged, 5);
  EXPECT_GT(out_of_plane, 5);
  EXPECT_GT(turned_away, 5);
  EXPECT_GT(arrived, 1);
}

std::map<std::string, Overlay> pictured(const GuidanceDriver& driver) {
  std::vector<Overlay> overlays;
  driver.guidance->append_overlays(overlays);
  std::map<std::string, Overlay> by_name;
  for (const Overlay& overlay : overlays) by_name[overlay.name] = overlay;
  return by_name;
}

TEST(RblWhole, ItsPictureShowsTheCellAtItsHeightAndWhereItGoes) {
  for (std::uint32_t round = 0; round < 10; ++round) {
    const Random random(round, "test.rbl-picture");
    RblConfig config;
    config.variant = Whole::k3d;
    config.separation.enabled = false;
    config.lidar.enabled = true;
    config.cells.lattice = RblCellConfig::Lattice::kWorld;
    config.goal_m = round % 2 == 0 ? Vector3(40, 5, 6) : Vector3(1.5, 2.0, 5.5);
    const Vector3 p_m(0.5, 1.0, 5.0 + 0.4 * config.cells.step_m);  // a layer lies 0.4 of a step below, one 0.6 above
    GuidanceDriver driver("rbl", config, p_m);
    const ToldMap map({{12.3, 1.0, 5.1}, {13.1, 1.0, 5.1}, {-40.0, 0.0, 5.0}});
    driver.map = &map;
    for (VehicleId id = 1; id <= 4; ++id) {
      const double angle = random.uniform(0.0, 6.2, 0, static_cast<std::uint32_t>(id));
      driver.sees(id, p_m + random.uniform(1.3, 4.0, 1, static_cast<std::uint32_t>(id)) *
                                Vector3(std::cos(angle), std::sin(angle), 0.1));
    }
    driver.step();
    auto shown = pictured(driver);
    ASSERT_EQ(shown.size(), 9U);
    // As far as the planes in each direction.
    NeighborMemory memory(config.neighbors);
    const double radius_m = config.cells.sensing_radius_m;
    RblPlanner planner(config.cells, config.rules, false);
    std::vector<Vector3> others_m;
    for (VehicleId id = 1; id <= 4; ++id) {
      const double angle = random.uniform(0.0, 6.2, 0, static_cast<std::uint32_t>(id));
      others_m.emplace_back(p_m + random.uniform(1.3, 4.0, 1, static_cast<std::uint32_t>(id)) *
                                      Vector3(std::cos(angle), std::sin(angle), 0.1));
    }
    planner.partition(p_m, others_m, -100.0, 100.0);
    double area_m2 = 0.0;
    for (int i = 0; i < 7200; ++i) {
      const double angle = 2.0 * kPi * i / 7200;
      double reach_m = radius_m;
      for (const HalfSpace& cut : planner.cuts()) {
        const double along = cut.normal_local.x() * std::cos(angle) + cut.normal_local.y() * std::sin(angle);
        if (along > 0.0) reach_m = std::min(reach_m, cut.offset_m / along);
      }
      area_m2 += kPi / 7200 * reach_m * reach_m;
    }
    const auto& outline = shown["rbl.cell_outline"].positions;
    double polygon_m2 = 0.0;
    for (std::size_t i = 0; i + 1 < outline.size(); ++i) {
      const Vector3 a = outline[i].cast<double>() - p_m, b = outline[i + 1].cast<double>() - p_m;
      polygon_m2 += 0.5 * a.cross(b).z();
    }
    EXPECT_NEAR(polygon_m2, area_m2, 0.01 * area_m2) << round;
    EXPECT_EQ(outline.front(), outline.back());
    double filled_m2 = 0.0;
    const auto& corners = shown["rbl.cell"].positions;
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
      filled_m2 += 0.5 * (corners[i + 1] - corners[i]).cross(corners[i + 2] - corners[i]).norm();
    EXPECT_NEAR(filled_m2, area_m2, 0.01 * area_m2) << round;
    const auto& circle = shown["rbl.sensing"].positions;
    ASSERT_EQ(circle.size(), 73U) << "a corner for every five degrees";
    for (std::size_t i = 0; i < circle.size(); ++i) {
      const double angle = 2.0 * kPi * static_cast<double>(i) / 72.0;
      const Vector3 q_m = p_m + radius_m * Vector3(std::cos(angle), std::sin(angle), 0.0);
      EXPECT_LT((circle[i].cast<double>() - q_m).norm(), 1e-5);
    }
    // Samples of the nearest layer.
    const auto& samples = shown["rbl.samples"].positions;
    ASSERT_FALSE(samples.empty());
    for (const Eigen::Vector3f& q : samples) EXPECT_NEAR(q.z(), 5.0, 1e-5);
    const double step_m2 = config.cells.step_m * config.cells.step_m;
    EXPECT_NEAR(static_cast<double>(samples.size()) * step_m2, area_m2, 0.1 * area_m2);
    // The destination is the goal at first: an arrow, a meter out of the sensing radius at most.
    const auto& arrow = shown["rbl.destination"].positions;
    ASSERT_EQ(arrow.size(), 2U);
    const Vector3 to_goal_m = config.goal_m - p_m;
    const Vector3 tip_m = p_m + std::min(to_goal_m.norm(), radius_m + 1.0) * to_goal_m.normalized();
    EXPECT_LT((arrow[0].cast<double>() - p_m).norm(), 1e-5);
    EXPECT_LT((arrow[1].cast<double>() - tip_m).norm(), 0.05);
    EXPECT_EQ(shown["rbl.goal"].positions.at(0), config.goal_m.cast<float>());
    ASSERT_EQ(shown["rbl.voxels"].positions.size(), 1U) << "within 12 m";
    EXPECT_NEAR(shown["rbl.voxels"].size_m, 0.2, 1e-6);
  }
}

TEST(RblWhole, NoCellLeavesNoOutlineAndSizesAndColorsTellThingsApart) {
  RblConfig config;
  config.variant = Whole::k3d;
  config.separation.enabled = false;
  config.lidar.enabled = true;
  GuidanceDriver driver("rbl", config, {0, 0, 5});
  const ToldMap map({{2.0, 1.0, 5.1}});
  driver.map = &map;
  driver.sees(1, {0.1, 0, 5});
  driver.sees(2, {-0.1, 0, 5});
  driver.step();
  auto shown = pictured(driver);
  EXPECT_TRUE(shown["rbl.cell_outline"].positions.empty());
  EXPECT_TRUE(shown["rbl.cell"].positions.empty());
  // Lines in pixels, spheres and points in meters: what matters most is drawn largest.
  const std::map<std::string, double> sizes = {
      {"rbl.cell_outline", 2.0},     {"rbl.sensing", 1.0},     {"rbl.samples", 0.06}, {"rbl.centroid", 0.16},
      {"rbl.sensing_centroid", 0.1}, {"rbl.destination", 3.0}, {"rbl.goal", 0.22}};
  for (const auto& [name, size] : sizes) EXPECT_NEAR(shown[name].size_m, size, 0.4 * size) << name;
  EXPECT_EQ(shown["rbl.cell"].size_m, 0.0F);
  for (const char* name : {"rbl.sensing", "rbl.samples", "rbl.sensing_centroid"}) {
    ASSERT_EQ(shown[name].colors.size(), 1U);
    const Eigen::Vector4f shade = shown[name].colors[0];
    EXPECT_LT(shade.head<3>().maxCoeff(), name == std::string("rbl.sensing") ? 0.14F : 0.07F) << "dark";
    EXPECT_LE(shade.w(), name == std::string("rbl.sensing") ? 0.8F : 1.0F);
  }
  const Eigen::Vector4f brown = shown["rbl.voxels"].colors.at(0);
  EXPECT_GT(brown.x(), brown.y());
  EXPECT_LT(brown.x(), 0.6F);
  EXPECT_GT(brown.y(), brown.z());
  EXPECT_LT(brown.z(), 0.25F);
  EXPECT_EQ(brown.w(), 1.0F);
}

}  // namespace
}  // namespace swiftlet
