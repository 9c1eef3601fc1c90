// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/sharing/map_join.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "core/slam/graph/graph_paths.hpp"
#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/frame_change.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/slam/pose_graph.hpp"

namespace swiftlet {
namespace {

// [-] Largest number of nodes of the search for the largest set of closures. Larger values take longer where many sets
// are equally large.
constexpr int kMaxCliqueNodes = 200000;
// Standard deviations [m, rad] of the newest own submap, which keeps its pose in the joint graph. Larger values let the
// joint solution move the own frame.
constexpr double kStandsStill_m = 1e-3, kStandsStill_rad = 1e-5;

struct JoinSigmas {
  double position_m2 = 0.0, attitude_rad2 = 0.0;
};

JoinSigmas odometry_of(double path_length_m, const MapJoinConfig& config) {
  const double length_m = std::max(std::abs(path_length_m), kMinPathLength_m);
  const double attitude = config.odometry_attitude_deg_sqrt_m * kRadPerDeg;
  return {config.odometry_position_m_sqrt_m * config.odometry_position_m_sqrt_m * length_m,
          attitude * attitude * length_m};
}

Matrix6 join_information(const JoinSigmas& variance) {
  Matrix6 information = Matrix6::Zero();
  information.diagonal().head<3>().setConstant(1.0 / variance.position_m2);
  information.diagonal().tail<3>().setConstant(1.0 / variance.attitude_rad2);
  return information;
}

JoinSigmas closure_sigmas(const MapJoinConfig& config) {
  const double attitude = config.closure_attitude_deg * kRadPerDeg;
  return {config.closure_position_m * config.closure_position_m, attitude * attitude};
}

/// Sets as bits. Among equally large sets the first in the order of the search is returned.
class LargestClique {
 public:
  explicit LargestClique(std::span<const std::uint64_t> agrees_with) : agrees_with_(agrees_with) {}
  std::uint64_t among(std::uint64_t candidates) {
    best_ = 0;
    nodes_ = 0;
    grow(0, candidates);
    return best_;
  }

 private:
  void grow(std::uint64_t clique, std::uint64_t candidates) {
    if (std::popcount(clique) > std::popcount(best_)) best_ = clique;
    while (candidates != 0 && nodes_ < kMaxCliqueNodes &&
           std::popcount(clique) + std::popcount(candidates) > std::popcount(best_)) {
      ++nodes_;
      const int next = std::countr_zero(candidates);
      candidates &= candidates - 1;
      grow(clique | std::uint64_t{1} << next, candidates & agrees_with_[static_cast<std::size_t>(next)]);
    }
  }
  std::span<const std::uint64_t> agrees_with_;
  std::uint64_t best_ = 0;
  int nodes_ = 0;
};

bool is_known(std::span<const SubmapPlace> places, int i) {
  return i >= 0 && static_cast<std::size_t>(i) < places.size() && places[static_cast<std::size_t>(i)].known;
}

/// A chain of poses joined by odometry; -1 where a place is unknown.
std::vector<int> add_chain(std::span<const SubmapPlace> places, const Pose& T_local_places, const MapJoinConfig& config,
                           PoseGraph& graph) {
  std::vector<int> poses(places.size(), -1);
  int last = -1;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!places[i].known) continue;
    const Pose& T = places[i].T_local_submap;
    poses[i] = graph.add_pose(T_local_places * T);
    graph.add(
        GravityFactor{poses[i], T.linear().transpose() * Vector3::UnitZ(), config.gravity_sigma_deg * kRadPerDeg});
    if (last >= 0) {
      const SubmapPlace& before = places[static_cast<std::size_t>(last)];
      graph.add(RelativeFactor{poses[static_cast<std::size_t>(last)], poses[i], before.T_local_submap.inverse() * T,
                               join_information(odometry_of(places[i].path_length_m - before.path_length_m, config)),
                               kNoHuber});
    }
    last = static_cast<int>(i);
  }
  return poses;
}

}  // namespace

double loop_chi2(const MapClosure& a, const MapClosure& b, std::span<const SubmapPlace> own,
                 std::span<const SubmapPlace> others, const MapJoinConfig& config) {
  const SubmapPlace &own_a = own[static_cast<std::size_t>(a.own)], &own_b = own[static_cast<std::size_t>(b.own)];
  const SubmapPlace &other_a = others[static_cast<std::size_t>(a.other)],
                    &other_b = others[static_cast<std::size_t>(b.other)];
  const Pose T_own_a_b = own_a.T_local_submap.inverse() * own_b.T_local_submap;
  const Pose T_other_a_b = other_a.T_local_submap.inverse() * other_b.T_local_submap;
  const Pose loop = a.T_own_other * T_other_a_b * b.T_own_other.inverse() * T_own_a_b.inverse();
  const JoinSigmas closure = closure_sigmas(config);
  const JoinSigmas own_odometry = odometry_of(own_b.path_length_m - own_a.path_length_m, config),
                   other_odometry = odometry_of(other_b.path_length_m - other_a.path_length_m, config);
  // A rotation displaces distant submaps in proportion to their distance.
  const double own_m2 = T_own_a_b.translation().squaredNorm(), last_m2 = b.T_own_other.translation().squaredNorm();
  const double other_m2 = (T_other_a_b * b.T_own_other.inverse()).translation().squaredNorm();
  const double attitude_rad2 = 2.0 * closure.attitude_rad2 + own_odometry.attitude_rad2 + other_odometry.attitude_rad2;
  const double position_m2 = 2.0 * closure.position_m2 + own_odometry.position_m2 + other_odometry.position_m2 +
                             closure.attitude_rad2 * (other_m2 + last_m2) + other_odometry.attitude_rad2 * other_m2 +
                             own_odometry.attitude_rad2 * own_m2;
  // Pose of the second own submap through the first closure, against its own pose.
  const Vector3 off_m = loop * T_own_a_b.translation() - T_own_a_b.translation();
  const Vector3 turn_rad = rotation_vector_rad(Eigen::Quaterniond(Matrix3(loop.linear())));
  return off_m.squaredNorm() / position_m2 + turn_rad.squaredNorm() / attitude_rad2;
}

std::vector<int> agreeing_closures(std::span<const MapClosure> closures, std::span<const SubmapPlace> own,
                                   std::span<const SubmapPlace> others, const MapJoinConfig& config) {
  const std::size_t num = closures.size();
  ENSURE(num <= 64, num);  // a bit for each
  std::vector<std::uint64_t> agrees_with(num, 0);
  std::uint64_t tested = 0;
  for (std::size_t i = 0; i < num; ++i) {
    if (!is_known(own, closures[i].own) || !is_known(others, closures[i].other)) continue;
    tested |= std::uint64_t{1} << i;
    for (std::size_t j = 0; j < i; ++j) {
      if ((tested >> j & 1U) == 0 || closures[i].other == closures[j].other) continue;
      if (!(loop_chi2(closures[i], closures[j], own, others, config) <= config.chi2_max)) continue;
      agrees_with[i] |= std::uint64_t{1} << j;
      agrees_with[j] |= std::uint64_t{1} << i;
    }
  }
  LargestClique search(agrees_with);
  const std::uint64_t best = search.among(tested), rival = search.among(tested & ~best);
  const int size = std::popcount(best);
  std::vector<int> agreeing;
  if (size < config.closures_min || 2 * std::popcount(rival) > size) return agreeing;
  for (std::size_t i = 0; i < num; ++i) {
    if ((best >> i & 1U) != 0) agreeing.push_back(static_cast<int>(i));
  }
  return agreeing;
}

MapJoin join_maps(std::span<const MapClosure> closures, std::span<const int> agreeing, std::span<const SubmapPlace> own,
                  std::span<const SubmapPlace> others, const MapJoinConfig& config) {
  ENSURE(!agreeing.empty() && !own.empty() && own.back().known, agreeing.size(), own.size());
  const MapClosure& first = closures[static_cast<std::size_t>(agreeing.front())];
  const Pose T_guess = own[static_cast<std::size_t>(first.own)].T_local_submap * first.T_own_other *
                       others[static_cast<std::size_t>(first.other)].T_local_submap.inverse();
  PoseGraph graph;
  const std::vector<int> own_poses = add_chain(own, Pose::Identity(), config, graph);
  const std::vector<int> other_poses = add_chain(others, T_guess, config, graph);
  graph.add(PriorFactor{own_poses.back(), own.back().T_local_submap,
                        join_information({kStandsStill_m * kStandsStill_m, kStandsStill_rad * kStandsStill_rad})});
  for (const int i : agreeing) {
    const MapClosure& closure = closures[static_cast<std::size_t>(i)];
    graph.add(RelativeFactor{own_poses[static_cast<std::size_t>(closure.own)],
                             other_poses[static_cast<std::size_t>(closure.other)], closure.T_own_other,
                             join_information(closure_sigmas(config)), config.closure_huber});
  }
  graph.optimize({});

  MapJoin joined;
  joined.T_local_other.resize(others.size(), Pose::Identity());
  std::size_t newest = 0;
  for (std::size_t i = 0; i < others.size(); ++i) {
    if (other_poses[i] < 0) continue;
    joined.T_local_other[i] = graph.pose(other_poses[i]);
    newest = i;
  }
  const Pose& T_newest = others[newest].T_local_submap;
  const Pose& T_found = joined.T_local_other[newest];
  joined.T_local_otherlocal = level_alignment(yaw_of(Matrix3(T_found.linear() * T_newest.linear().transpose())),
                                              T_found.translation(), T_newest.translation());
  const Matrix6 covariance = graph.covariance_of(other_poses[newest]);
  const int rows[] = {0, 1, 2, 5};  // components of a level pose: position and heading
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) joined.covariance(i, j) = covariance(rows[i], rows[j]);
  }
  return joined;
}

void MapJoinConfig::visit(ConfigVisitor& v) {
  v.field("closures_min", closures_min, "[-] consistent closures required to join two maps", Range::between(2, 64));
}

}  // namespace swiftlet
