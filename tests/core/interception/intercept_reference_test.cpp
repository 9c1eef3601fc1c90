// SPDX-License-Identifier: BSD-3-Clause
// The interceptor beside its decisions written out: whom it hunts, when it lets go, and what it flies meanwhile. What
// the decisions are made with (prediction, plan, search, surroundings, net) has references of its own.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/interception/chase_planner.hpp"
#include "core/interception/surroundings.hpp"
#include "swiftlet/core/interception/intercept.hpp"
#include "swiftlet/core/interception/pursuit_laws.hpp"
#include "swiftlet/core/math/random.hpp"
#include "tests/core/guidance/guidance_driver.hpp"

namespace swiftlet {
namespace {

using Method = InterceptConfig::Method;

constexpr MotionLimits kHunter{8.0, 4.0, 60.0, 4.0, 2.0, 60.0, 2.0, 2.0};
constexpr double kTick_s = 0.02;

/// What is there to know in one tick.
struct Scene {
  TimeNs t = 0;
  Vector3 p_m = Vector3::Zero();
  std::vector<Track> tracks;
  std::vector<TrackModes> modes;
  Geofence fence;
  const OccupancyView* map = nullptr;
};

class PlainHunter {
 public:
  PlainHunter(const InterceptConfig& config, const Reference& start)
      : c_(config),
        governor_(kHunter),
        planner_(config.plan, kHunter, 0.8 * config.sure_share * config.net.radius_m),
        search_(config.search),
        watch_m_(start.position_m),
        yaw_rad_(start.yaw_rad) {
    governor_.reset(start);
    around_.clearance_m = config.clearance_m;
    sure_ = config.net;
    sure_.radius_m *= config.sure_share;
    sure_.height_m *= config.sure_share;
  }

  const Reference& tick(const Scene& scene) {
    p_m_ = scene.p_m;
    now_ = scene.t;
    around_.fence = scene.fence;
    around_.map = c_.walls == InterceptConfig::Walls::kMap ? scene.map : nullptr;
    for (int axis = 0; axis < 3; ++axis)
      bias_m_[axis] = std::clamp(p_m_[axis] - governor_.state().position_m[axis], -0.5, 0.5);
    const Track* target = chosen(scene);
    if (target != nullptr) take(*target, scene);
    list_bystanders(scene, target);
    const bool caught = target != nullptr && catches();
    decide(target != nullptr, caught);
    if (!planned_ || since_s_ >= c_.period_s) think();
    fly(governor_, since_s_, 0.0, kTick_s);
    since_s_ += kTick_s;
    return governor_.state();
  }

  std::string note;
  std::string mode = "waiting";
  std::map<std::string, int> seen;  // ticks by mode, and of braking

 private:
  const Track* chosen(const Scene& scene) const {
    const Track* best = nullptr;
    double least = 1e300;
    for (const Track& track : scene.tracks) {
      if (to_seconds(now_ - track.t) > c_.track_timeout_s) continue;
      double far = (track.position_m - p_m_).norm();
      if (!c_.target.empty()) {
        if (track.id != 2) continue;  // the second vehicle
      } else if (target_) {
        const double gone_s = to_seconds(now_ - seen_at_);
        far = (track.position_m - target_->at(gone_s).p_m).norm();
        if (track.id == id_)
          far = -1.0;
        else if (mode == "chasing" && far > 3.0 + 3.0 * gone_s)
          continue;
      }
      if (far < least) best = &track;
      least = std::min(least, far);
    }
    return best;
  }

  void take(const Track& track, const Scene& scene) {
    const TrackModes* modes = nullptr;
    for (const TrackModes& one : scene.modes) {
      if (one.id == track.id && modes == nullptr) modes = &one;
    }
    if (!target_ || track.id != id_) {
      last_net_m_.reset();
      found_at_s_ = -1e9;
    }
    target_ = TargetPrediction(c_.prediction, track, modes, now_);
    id_ = track.id;
    if (track.corrected) found_at_s_ = to_seconds(track.t);
    seen_at_ = now_;
  }

  void list_bystanders(const Scene& scene, const Track* target) {
    around_.bystanders.clear();
    for (const Track& track : scene.tracks) {
      if (&track == target) continue;
      const bool same = target != nullptr && c_.target.empty() && (track.position_m - target->position_m).norm() < 2.5;
      if (same) continue;
      const Vector3 now_m = track.position_m + to_seconds(now_ - track.t) * track.velocity_mps;
      around_.bystanders.push_back({now_m, track.velocity_mps, c_.bystander_clearance_m, false});
    }
    if (target != nullptr && c_.target_clearance_m > 0.0)
      around_.bystanders.push_back(
          {target_->at(0.0).p_m, target_->at(0.0).v_mps, c_.target_clearance_m, c_.net.offset_m.z() < 0.0});
  }

  Vector3 net_m() const { return c_.net.center(p_m_, governor_.state().yaw_rad); }

  bool catches() {
    const Vector3 from_net_m = target_->at(0.0).p_m - net_m();
    is_ready_ = is_ready_ || from_net_m.norm() > c_.net.rearm_m;
    const bool is_sure = to_seconds(now_) - found_at_s_ < 0.5;
    const bool caught = is_ready_ && is_sure && last_net_m_ && sure_.met_m(*last_net_m_, from_net_m);
    last_net_m_ = from_net_m;
    if (caught) {
      is_ready_ = false;
      ++num_caught_;
    }
    return caught;
  }

  void enter(const std::string& next) {
    if (next == "chasing" && mode != "leaving") outside_s_ = 0.0;
    mode = next;
    in_mode_s_ = 0.0;
    planned_ = false;
    planner_.forget();
  }

  void decide(bool sees, bool caught) {
    ++seen[mode];
    in_mode_s_ += kTick_s;
    if (mode == "waiting") {
      note = "waiting for a target";
      if (sees) enter("chasing");
    } else if (mode == "searching") {
      note = "the target is lost: searching";
      look_for_it();
      if (sees) {
        enter("chasing");
      } else if (in_mode_s_ > c_.search.timeout_s) {
        why_ = "gave up: the target was not found again";
        enter("given up");
      }
    } else if (mode == "leaving") {
      note = "captured";
      if (is_ready_ || in_mode_s_ > c_.after_capture_s) enter("chasing");
    } else if (mode == "chasing") {
      note = "chasing";
      outside_s_ = around_.fence.excess_m(target_->at(0.0).p_m) > 0.0 ? outside_s_ + kTick_s : 0.0;
      if (!sees) {
        last_net_m_.reset();
        search_.begin(target_->at(0.0), std::max(0.5, target_->sigma_m(0.0)), 1.0);
        look_s_ = think_s_ = 0.0;
        goal_m_ = target_->at(c_.track_timeout_s).p_m;
        highest_m_ = search_.highest_near_m(p_m_);
        enter("searching");
      } else if (outside_s_ > c_.fence.patience_s) {
        why_ = "gave up: the target left the fence";
        enter("given up");
      }
    } else if (mode == "given up") {
      note = why_;
    }
    if (!caught || mode == "given up" || mode == "done") return;
    note = "captured";
    if (c_.captures > 0 && num_caught_ >= c_.captures)
      enter("done");
    else if (c_.method == Method::kMpc)
      enter("leaving");
  }

  void look_for_it() {
    look_s_ += kTick_s;
    think_s_ += kTick_s;
    if (look_s_ < 0.2) return;
    search_.advance(look_s_, around_.fence);
    search_.look(p_m_, look_s_, around_.map);
    look_s_ = 0.0;
    highest_m_ = search_.highest_near_m(p_m_);
    if (think_s_ < 1.0) return;
    think_s_ = 0.0;
    goal_m_ = search_.most_probable();
  }

  void think() {
    planned_ = true;
    const double since_last_s = since_s_;
    since_s_ = 0.0;
    const Reference& r = governor_.state();
    if (mode == "chasing" && c_.method == Method::kMpc) {
      const Vector3 to_net_m = c_.net.center(Vector3::Zero(), r.yaw_rad);
      const double above_m = net_m().z() - target_->at(0.0).p_m.z();
      if (std::abs(above_m) > 0.05) side_ = above_m > 0.0 ? 1.0 : -1.0;
      planner_.plan({r.position_m, r.velocity_mps, r.acceleration_mps2}, *target_, to_net_m + bias_m_ - way_around_m(),
                    c_.net.height_m > 0.0 ? 0.0 : side_, around_, since_last_s);
    }
    // Tried for a period, and braked then: does that end well?
    brakes_ = false;
    ReferenceGovernor tried = governor_;
    const int parts = std::max(1, static_cast<int>(std::ceil(c_.period_s / 0.01)));
    for (int i = 0; i < parts; ++i) fly(tried, 0.01 * i, 0.01 * i, 0.01);
    brakes_ = !can_stop(tried, around_, c_.period_s, std::max(0.0, around_.intrusion_m(r.position_m, 0.0)));
    seen["braking"] += brakes_;
  }

  /// Beside a target that is not yet below, when the net hangs below.
  Vector3 way_around_m() const {
    const Vector3 off_m = p_m_ - target_->at(0.0).p_m, v_mps = target_->at(0.0).v_mps;
    if (c_.net.offset_m.z() >= 0.0 || c_.target_clearance_m <= 0.0 || off_m.z() > 0.8 * c_.target_clearance_m)
      return Vector3::Zero();
    for (const Vector3& beside : {Vector3(off_m.x(), off_m.y(), 0.0), Vector3(-v_mps.y(), v_mps.x(), 0.0)}) {
      if (beside.norm() >= 0.05) return 1.7 * c_.target_clearance_m * beside.normalized();
    }
    return {1.7 * c_.target_clearance_m, 0.0, 0.0};
  }

  void fly(ReferenceGovernor& governor, double since_s, double ahead_s, double h) {
    const Reference& r = governor.state();
    if (brakes_) {
      governor.accelerate(braking_mps2(r, around_, ahead_s, kHunter), yaw_rad_, h);
      return;
    }
    if (mode == "chasing" || mode == "leaving") look_at(target_->at(ahead_s).p_m);
    if (mode == "chasing" && c_.method == Method::kMpc) {
      const PointState planned = planner_.at(since_s + h);
      governor.step({.position_m = planned.p_m,
                     .velocity_mps = planned.v_mps,
                     .acceleration_mps2 = planned.a_mps2,
                     .yaw_rad = yaw_rad_},
                    h);
    } else if (mode == "chasing") {
      const RelativeMotion relative{target_->at(ahead_s).p_m - c_.net.center(r.position_m + bias_m_, r.yaw_rad),
                                    target_->at(ahead_s).v_mps - r.velocity_mps};
      Vector3 a_mps2 = pure_pursuit_mps2(c_.gains, relative);
      if (c_.method == Method::kFrpn) a_mps2 = frpn_mps2(c_.gains, relative);
      if (c_.method == Method::kProportionalNavigation) a_mps2 = proportional_navigation_mps2(c_.gains, relative);
      governor.accelerate(within_acceleration(a_mps2, kHunter), yaw_rad_, h);
    } else if (mode == "leaving") {
      // On along the way on which it flies past, or against the target's, or anywhere.
      const Vector3 v_mps = target_->at(0.0).v_mps;
      Vector3 away = r.velocity_mps - v_mps;
      if (away.head<2>().norm() < 0.5) away = -v_mps;
      away.z() = 0.0;
      if (away.norm() < 0.5) away = Vector3::UnitX();
      governor.accelerate(4.0 * away.normalized(), yaw_rad_, h);
    } else {
      Reference goal;
      goal.position_m = watch_m_;
      const Vector3 net_m = c_.net.center(Vector3::Zero(), r.yaw_rad);
      if (mode == "searching") goal.position_m = goal_m_ - net_m;
      if (mode == "searching" && net_m.z() < 0.0) goal.position_m.z() = std::max(goal_m_.z(), highest_m_) - net_m.z();
      if (mode == "done") goal.position_m.z() += 1000.0;
      goal.position_m = around_.fence.inside(goal.position_m);
      look_at(goal.position_m);
      goal.yaw_rad = yaw_rad_;
      governor.step(goal, h);
    }
  }

  void look_at(const Vector3& place_m) {
    const Vector3 to_m = place_m - p_m_;
    if (to_m.head<2>().norm() > 1.0) yaw_rad_ = std::atan2(to_m.y(), to_m.x());
  }

  InterceptConfig c_;
  ReferenceGovernor governor_;
  ChasePlanner planner_;
  TargetSearch search_;
  Surroundings around_;
  CaptureVolume sure_;
  std::optional<TargetPrediction> target_;
  std::uint32_t id_ = 0;
  TimeNs now_ = 0, seen_at_ = 0;
  double found_at_s_ = -1e9;
  double highest_m_ = 0.0;
  Vector3 watch_m_, goal_m_ = Vector3::Zero(), p_m_ = Vector3::Zero(), bias_m_ = Vector3::Zero();
  std::optional<Vector3> last_net_m_;
  std::string why_;
  double yaw_rad_, in_mode_s_ = 0.0, outside_s_ = 0.0, since_s_ = 0.0, look_s_ = 0.0, think_s_ = 0.0, side_ = 1.0;
  bool planned_ = false, brakes_ = false, is_ready_ = true;
  int num_caught_ = 0;
};

/// Flies about, out of the fence at times; another one near it, and one that is somewhere else.
struct Sky {
  Sky(std::uint32_t round_in, bool named_in) : random(round_in, "test.sky"), named(named_in) {}

  void show(Scene& scene) const {
    const double t_s = to_seconds(scene.t);
    const auto leg = static_cast<std::uint32_t>(t_s / 2.5);
    scene.tracks.clear();
    scene.modes.clear();
    const double w = random.uniform(0.1, 0.5, 0, 0), r_m = random.uniform(3.0, 12.0, 0, 1);
    const Vector3 out(std::cos(w * t_s), std::sin(w * t_s), 0.0), along(-out.y(), out.x(), 0.0);
    const Vector3 drift(random.uniform(-0.8, 0.8, 0, 2), random.uniform(-0.8, 0.8, 0, 3), 0.0);
    Track track;
    track.id = named ? 2 : 5 + leg / 3;  // tracks end, and others begin
    const double age_s = random.uniform(leg, 4) < 0.3 ? 0.6 : 0.02;
    track.t = scene.t - from_seconds(age_s);
    track.corrected = random.uniform(leg, 13) < 0.7;  // else it goes on without a measurement
    track.position_m = Vector3(0, 0, 14) + t_s * drift + r_m * out;
    track.velocity_mps = drift + r_m * w * along;
    track.acceleration_mps2 = -r_m * w * w * out;
    track.covariance.setIdentity();
    track.covariance *= random.uniform(leg, 5) < 0.5 ? 1e-3 : 1.0;
    if (random.uniform(leg, 6) > 0.25) scene.tracks.push_back(track);  // it is lost at times
    if (random.uniform(leg, 7) < 0.5) {
      TrackModes modes;
      modes.id = track.id;
      modes.probability = {0.5, 0.3, 0.2};
      for (auto& mean : modes.mean_local_m) mean << track.position_m, track.velocity_mps, track.acceleration_mps2;
      scene.modes.push_back(modes);
    }
    Track second = track;  // of the same target, or of somebody else
    second.id = 100;
    second.position_m += (random.uniform(leg, 8) < 0.5 ? 2.3 : 2.7) * Vector3(0.6, 0.0, 0.8);
    if (random.uniform(leg, 9) < 0.3) scene.tracks.push_back(second);
    Track other = track;
    other.id = 101;
    other.t = scene.t - from_seconds(0.5);
    other.position_m = {random.uniform(-15, 15, leg, 10), random.uniform(-15, 15, leg, 11), 12.0};
    other.velocity_mps = {1.0, -0.5, 0.2};
    if (random.uniform(leg, 12) < 0.3) scene.tracks.insert(scene.tracks.begin(), other);
  }

  Random random;
  bool named;
};

TEST(InterceptReference, EveryTickIsThatOfTheDecisions) {
  std::map<std::string, int> seen;
  for (std::uint32_t round = 0; round < 40; ++round) {
    const Random random(round, "test.hunter");
    std::uint32_t index = 0;
    const auto draw = [&](double min, double max) { return random.uniform(min, max, 0, index++); };
    InterceptConfig config;
    config.method = round % 2 == 0 ? Method::kMpc : static_cast<Method>(round / 2 % 4);
    config.target = round % 4 == 1 ? "target" : "";
    config.captures = static_cast<int>(round) % 3;
    config.net.radius_m = draw(1.0, 2.5);
    config.net.height_m = round % 3 == 0 ? draw(0.5, 2.0) : 0.0;
    config.net.offset_m = {draw(-0.5, 0.5), draw(-0.5, 0.5), round % 5 == 4 ? 1.0 : -1.2};
    config.sure_share = draw(0.5, 1.0);
    config.target_clearance_m = round % 6 == 5 ? 0.0 : draw(0.5, 1.2);
    config.bystander_clearance_m = draw(1.0, 3.0);
    config.track_timeout_s = draw(0.65, 1.2);
    config.after_capture_s = draw(0.5, 2.5);
    config.period_s = round % 7 == 6 ? 0.015 : 0.06;
    config.search.timeout_s = draw(1.5, 6.0);
    config.plan.steps = 6;
    config.plan.solver.iterations = 20;
    config.fence.min_m = {-18.0, -18.0, 3.0};
    config.fence.max_m = {18.0, draw(9.0, 18.0), 24.0};
    config.fence.patience_s = draw(0.5, 3.0);
    config.walls = round % 3 == 1 ? InterceptConfig::Walls::kMap : InterceptConfig::Walls::kNone;
    std::vector<Vector3> cells_m;
    for (int i = 0; i < 12; ++i) cells_m.emplace_back(draw(-9.0, 9.0), draw(-9.0, 9.0), draw(6.0, 14.0));
    const testing::ToldMap map(cells_m);

    AgentSetup setup;
    const Vector3 start_m(draw(-12.0, 12.0), draw(-12.0, 12.0), draw(8.0, 18.0));
    setup.T_local_body_start = make_pose(start_m, Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Vector3::UnitZ())));
    setup.vehicle_names = {"interceptor", "target"};
    setup.num_vehicles = 2;
    Module module(guidance_module_types(), "intercept");
    module.as<InterceptConfig>() = config;
    const auto guidance = make_guidance(module, {setup, kHunter});
    StateEstimate estimate;
    estimate.valid = true;
    estimate.T_local_body = setup.T_local_body_start;
    estimate.v_local_mps = {0.5, 0.0, -0.2};
    if (round % 3 == 2) estimate.correct(level_alignment(0.5, {1.0, -2.0, 0.5}, Vector3::Zero()));
    Reference start;
    start.position_m = start_m;
    start.velocity_mps = estimate.v_local_mps;
    start.yaw_rad = 0.4;
    PlainHunter plain(config, start);
    const Sky sky(round, !config.target.empty());
    Observation observation;
    LocalPoses poses;
    GuidanceOutput out;
    Outbox outbox;
    Scene scene;
    scene.fence = Geofence(config.fence, FrameChange::to_local(estimate));
    scene.map = &map;
    for (std::uint32_t tick = 1; tick <= 900; ++tick) {
      observation.t = estimate.t = scene.t = from_seconds(kTick_s) * tick;
      poses.push(estimate);
      if (tick > 10) sky.show(scene);
      scene.p_m = estimate.T_local_body.translation();
      guidance->step({.dt_s = kTick_s,
                      .estimate = estimate,
                      .observation = observation,
                      .poses = poses,
                      .tracks = scene.tracks,
                      .track_modes = scene.modes,
                      .map = &map},
                     out, outbox);
      const Reference& expected = plain.tick(scene);
      ASSERT_LT((out.goal.position_m - expected.position_m).norm(), 1e-9) << round << ", " << tick << ' ' << plain.mode;
      ASSERT_LT((out.goal.velocity_mps - expected.velocity_mps).norm(), 1e-9);
      ASSERT_NEAR(out.goal.yaw_rad, expected.yaw_rad, 1e-9) << round << ", " << tick << ' ' << plain.mode;
      ASSERT_EQ(std::string(out.note), plain.note) << round << ", " << tick;
      ASSERT_EQ(out.mission, plain.mode == "done"       ? MissionStatus::kDone
                             : plain.mode == "given up" ? MissionStatus::kFailed
                                                        : MissionStatus::kRunning);
      ASSERT_TRUE(out.goal_is_feasible);
      // It knows where it is, but for a few decimeters at times.
      const double off_m = round % 4 == 3 ? 0.7 : 0.2;
      const Vector3 off = off_m * Vector3(std::sin(0.03 * tick), std::cos(0.02 * tick), std::sin(0.05 * tick));
      estimate.T_local_body = make_pose(out.goal.position_m + off,
                                        Eigen::Quaterniond(Eigen::AngleAxisd(out.goal.yaw_rad, Vector3::UnitZ())));
    }
    for (const auto& [what, ticks] : plain.seen) seen[what] += ticks;
  }
  for (const char* what : {"waiting", "chasing", "searching", "leaving", "given up", "done", "braking"})
    EXPECT_GT(seen[what], 50) << what;
}

TEST(InterceptReference, ItAsksForAMapWhereItKeepsClearOfIt) {
  const AgentSetup agent;
  for (const auto walls : {InterceptConfig::Walls::kNone, InterceptConfig::Walls::kMap}) {
    Module module(guidance_module_types(), "intercept");
    module.as<InterceptConfig>().walls = walls;
    const GuidanceNeeds needs = make_guidance(module, {agent, kHunter})->needs();
    EXPECT_EQ(needs.map, walls == InterceptConfig::Walls::kMap);
    EXPECT_TRUE(needs.track_modes);
  }
}

// ---- surroundings

TEST(SurroundingsReference, RoomWallsAndBrakingAreThoseOfTheirFormulas) {
  int evades = 0, stops = 0, does_not = 0;
  for (std::uint32_t round = 0; round < 400; ++round) {
    const Random random(round, "test.surroundings");
    std::uint32_t index = 0;
    const auto draw = [&](double min, double max) { return random.uniform(min, max, 0, index++); };
    const auto vector = [&](double half) {
      const double x = draw(-half, half), y = draw(-half, half);
      return Vector3(x, y, draw(-half, half));
    };
    Surroundings around;
    GeofenceConfig fence;
    fence.min_m = {-7.0, -7.0, -7.0};
    fence.max_m = {7.0, 7.0, 7.0};
    around.fence = Geofence(fence, FrameChange());
    around.clearance_m = draw(0.5, 2.0);
    std::vector<Vector3> cells_m;
    const int num_cells = static_cast<int>(4.0 * draw(0.0, 1.0));
    for (int i = 0; i < num_cells; ++i) cells_m.push_back(vector(6.0));
    const testing::ToldMap map(cells_m, 0.4);
    if (round % 3 != 0) around.map = &map;
    const int num_others = static_cast<int>(3.0 * draw(0.0, 1.0));
    for (int i = 0; i < num_others; ++i)
      around.bystanders.push_back({vector(6.0), vector(3.0), draw(0.5, 2.5), draw(0.0, 1.0) < 0.5});
    const Vector3 p_m = vector(6.5);
    const double ahead_s = draw(0.0, 1.5);

    double room_m = 1.0;
    for (int axis = 0; axis < 3; ++axis) room_m = std::min(room_m, 7.0 - std::abs(p_m[axis]));
    if (around.map != nullptr) room_m = std::min(room_m, map.distance_m(p_m, 100.0) - around.clearance_m);
    for (const Bystander& other : around.bystanders)
      room_m = std::min(room_m, (other.p_local_m + ahead_s * other.v_local_mps - p_m).norm() - other.radius_m);
    EXPECT_NEAR(around.intrusion_m(p_m, ahead_s), -room_m, 1e-9) << round;

    // The nearest cell, everybody, and the fence; what is within three meters, four at most.
    std::vector<Wall> walls;
    const auto add_ball = [&](const Vector3& center_m, double radius_m) {
      const Vector3 to_m = center_m - p_m;
      if (to_m.norm() <= radius_m + 3.0)
        walls.push_back({to_m.normalized(), to_m.normalized().dot(center_m) - radius_m});
    };
    const Vector3* nearest = nullptr;
    for (const Vector3& cell_m : cells_m) {
      const Vector3 off = ((p_m - cell_m).cwiseAbs() - Vector3::Constant(0.2)).cwiseMax(0.0);
      if (around.map == nullptr || off.norm() > around.clearance_m + 3.0) continue;
      if (nearest == nullptr || (cell_m - p_m).norm() < (*nearest - p_m).norm()) nearest = &cell_m;
    }
    if (nearest != nullptr) add_ball(*nearest, around.clearance_m + 0.87 * 0.4);
    for (const Bystander& other : around.bystanders) {
      const Vector3 center_m = other.p_local_m + ahead_s * other.v_local_mps, above_m = p_m - center_m;
      if (!other.flown_over || above_m.z() < 0.5 * other.radius_m)
        add_ball(center_m, other.radius_m);
      else if (std::hypot(above_m.x(), above_m.y()) < other.radius_m + 0.5)
        walls.push_back({-Vector3::UnitZ(), -center_m.z() - other.radius_m});
    }
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sense : {-1.0, 1.0}) {
        if (7.0 - sense * p_m[axis] < 3.0) walls.push_back({sense * Vector3::Unit(axis), 7.0});
      }
    }
    ChaseAim aim;
    around.walls(p_m, ahead_s, aim);
    ASSERT_EQ(static_cast<std::size_t>(aim.num_walls), std::min<std::size_t>(walls.size(), 4)) << round;
    for (int i = 0; i < aim.num_walls; ++i) {
      EXPECT_LT((aim.walls[i].normal - walls[i].normal).norm(), 1e-9);
      EXPECT_NEAR(aim.walls[i].offset_m, walls[i].offset_m, 1e-9);
    }

    // Against the velocity, and away from whoever will be within reach in the next second and a half.
    Reference state;
    state.position_m = p_m;
    state.velocity_mps = vector(3.0);
    const auto plain_braking = [&](const Reference& r, double then_s) {
      Vector3 a = -6.0 * r.velocity_mps;
      for (const Bystander& other : around.bystanders) {
        const Vector3 off_m = r.position_m - other.p_local_m - then_s * other.v_local_mps;
        const Vector3 off_mps = r.velocity_mps - other.v_local_mps;
        double t_s = -off_m.dot(off_mps) / std::max(off_mps.squaredNorm(), 1e-6);
        t_s = std::min(std::max(t_s, 0.0), 1.5);
        const Vector3 nearest_m = off_m + t_s * off_mps;
        if (nearest_m.norm() > other.radius_m + 0.3) continue;
        a += 8.0 * (nearest_m.norm() > 0.1 ? Vector3(nearest_m.normalized()) : Vector3(0, 0, 1));
        ++evades;
      }
      const double over = std::max({1.0, std::hypot(a.x(), a.y()) / 4.0, std::abs(a.z()) / 2.0});
      return Vector3(a / over);
    };
    EXPECT_LT((braking_mps2(state, around, ahead_s, kHunter) - plain_braking(state, ahead_s)).norm(), 1e-9) << round;

    // Step by step until it rests, for six seconds at most; looked at ten times a second, and at the end.
    ReferenceGovernor governor(kHunter);
    governor.reset(state);
    const double allowed_m = draw(0.0, 0.5);
    const bool got = can_stop(governor, around, ahead_s, allowed_m);
    bool expected = around.intrusion_m(p_m, ahead_s) <= allowed_m;
    double looked_s = 0.0;
    for (int i = 1; i <= 300 && expected; ++i) {
      const double t_s = 0.02 * i;
      governor.accelerate(plain_braking(governor.state(), ahead_s + t_s), governor.state().yaw_rad, 0.02);
      const bool rests = governor.state().velocity_mps.norm() < 0.05;
      if (rests || t_s - looked_s >= 0.1) {
        looked_s = t_s;
        expected = around.intrusion_m(governor.state().position_m, ahead_s + t_s) <= allowed_m;
      }
      if (rests) break;
    }
    EXPECT_EQ(got, expected) << round;
    ++(expected ? stops : does_not);
  }
  EXPECT_GT(evades, 200);
  EXPECT_GT(stops, 50);
  EXPECT_GT(does_not, 20);
}

TEST(SurroundingsReference, WhoIsChasedForEverIsGivenSixSecondsToStop) {
  // Somebody stays at its heels: it never rests, and is never too near. At 1.3 m/s it rises 8 m meanwhile.
  for (const double ceiling_m : {6.0, 10.0}) {
    Surroundings around;
    GeofenceConfig fence;
    fence.min_m = {-1e4, -1e4, -1e4};
    fence.max_m = {1e4, 1e4, ceiling_m};
    around.fence = Geofence(fence, FrameChange());
    around.bystanders.push_back({{0, 0, -1.2}, {0, 0, 1.3}, 1.0, false});
    ReferenceGovernor governor(kHunter);
    Reference rises;
    rises.velocity_mps = {0, 0, 1.33};
    governor.reset(rises);
    EXPECT_EQ(can_stop(governor, around, 0.0, 0.0), ceiling_m > 9.0);
  }
}

}  // namespace
}  // namespace swiftlet
