// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/slam/saved_map.hpp"

#include <algorithm>
#include <cmath>

#include "core/slam/matching/sweep.hpp"

namespace swiftlet {
namespace {

// [-] Tolerance of the orthogonality of a rotation. Smaller values refuse maps with rounded poses.
constexpr double kRigid = 1e-6;

bool is_pose(const Pose& T) {
  return T.matrix().allFinite() && (T.linear() * T.linear().transpose() - Matrix3::Identity()).norm() < kRigid &&
         T.linear().determinant() > 0.0;
}

bool is_scale(double huber) { return huber > 0.0; }  // infinite: no Huber loss

}  // namespace

std::string fault_of(const SavedMap& map) {
  if (!(map.voxel_m > 0.0 && std::isfinite(map.voxel_m))) return "the edge of its voxels is not positive";
  const PoseGraph& graph = map.graph;
  const auto known = [&](int pose) { return pose >= 0 && pose < graph.num_poses(); };
  for (int i = 0; i < graph.num_poses(); ++i) {
    if (!is_pose(graph.pose(i))) return "pose " + std::to_string(i) + " is none";
  }
  const auto relatives = graph.relative_factors();
  if (!std::all_of(relatives.begin(), relatives.end(), [&](const RelativeFactor& f) {
        return known(f.from) && known(f.to) && f.from != f.to && is_pose(f.T_from_to) && f.information.allFinite() &&
               is_scale(f.huber);
      })) {
    return "a constraint between poses is invalid";
  }
  const auto priors = graph.prior_factors();
  if (!std::all_of(priors.begin(), priors.end(), [&](const PriorFactor& f) {
        return known(f.pose) && is_pose(f.T_world_pose) && f.information.allFinite();
      })) {
    return "the prior of a pose is invalid";
  }
  const auto gravities = graph.gravity_factors();
  if (!std::all_of(gravities.begin(), gravities.end(), [&](const GravityFactor& f) {
        return known(f.pose) && f.up_body.allFinite() && f.sigma_rad > 0.0 && std::isfinite(f.sigma_rad);
      })) {
    return "a direction of gravity is invalid";
  }
  const auto positions = graph.position_factors();
  if (!std::all_of(positions.begin(), positions.end(), [&](const PositionFactor& f) {
        return known(f.before) && known(f.after) && std::isfinite(f.beta) && f.p_world_m.allFinite() &&
               f.weight_world_1_m.allFinite() && is_scale(f.huber);
      })) {
    return "a measured position is invalid";
  }
  if (!std::all_of(map.nodes.begin(), map.nodes.end(), [&](const SavedMap::Node& n) { return known(n.pose); })) {
    return "a node has no pose";
  }
  for (const SavedMap::Submap& submap : map.submaps) {
    if (!known(submap.pose)) return "a submap has no pose";
    if (!std::all_of(submap.points_submap_m.begin(), submap.points_submap_m.end(),
                     [](const Eigen::Vector3f& p) { return p.allFinite(); })) {
      return "a point is not finite";
    }
  }
  const auto num_submaps = static_cast<int>(map.submaps.size());
  for (const MapPiece& piece : map.pieces) {
    if (piece.submap < 0 || piece.submap >= num_submaps || !is_pose(piece.T_submap_cells) || piece.cells == nullptr) {
      return "cells belong to no submap";
    }
  }
  return "";
}

std::vector<MapPiece> pieces_of(const SavedMap& map) {
  std::vector<MapPiece> pieces = map.pieces;
  std::vector<bool> seen(map.submaps.size(), false);
  for (const MapPiece& piece : map.pieces) seen[static_cast<std::size_t>(piece.submap)] = true;
  for (std::size_t i = 0; i < map.submaps.size(); ++i) {
    const std::vector<Eigen::Vector3f>& points_m = map.submaps[i].points_submap_m;
    if (seen[i] || points_m.empty()) continue;
    pieces.push_back({static_cast<int>(i), Pose::Identity(),
                      std::make_shared<const SubmapCells>(SubmapCells::of_points(map.voxel_m, points_m))});
  }
  return pieces;
}

std::shared_ptr<const SavedMap> with_pieces(std::shared_ptr<const SavedMap> map, const SubmapPoses& poses,
                                            std::span<const MapPiece> own) {
  const std::size_t num_own = poses.T_local_own.size(), num_given = poses.num_given;
  if (map == nullptr || own.empty() || map->submaps.size() != num_given + num_own) return map;
  auto whole = std::make_shared<SavedMap>(*map);
  for (MapPiece piece : own) {
    piece.submap += static_cast<int>(num_given);
    whole->pieces.push_back(std::move(piece));
  }
  return whole;
}

std::vector<Eigen::Vector3f> points_world_m(const SavedMap& map) {
  std::size_t size = 0;
  for (const SavedMap::Submap& submap : map.submaps) size += submap.points_submap_m.size();
  std::vector<Eigen::Vector3f> points_m;
  points_m.reserve(size);
  for (const SavedMap::Submap& submap : map.submaps) {
    const Pose& T_world_submap = map.T_world_submap(submap);
    for (const Eigen::Vector3f& p : submap.points_submap_m) {
      points_m.push_back((T_world_submap * p.cast<double>()).cast<float>());
    }
  }
  return points_m;
}

void append_voxels(const SavedMap& map, const Pose& T_local_world, MapVoxels& copy) {
  copy.edge_m = map.voxel_m;
  copy.states = {"free", "occupied"};
  copy.occupied_from = 1;
  std::vector<Eigen::Vector3f> points_local_m = points_world_m(map);
  for (Eigen::Vector3f& p : points_local_m) p = (T_local_world * p.cast<double>()).cast<float>();
  std::vector<std::uint32_t> kept;
  kept.reserve(points_local_m.size());
  VoxelThinner().thin(points_local_m, static_cast<float>(map.voxel_m), kept);
  copy.centers_local_m.reserve(kept.size());
  copy.state.reserve(kept.size());
  copy.value.reserve(kept.size());
  for (const std::uint32_t i : kept) {
    const Vector3 cell = (points_local_m[i].cast<double>() / map.voxel_m).array().floor();
    copy.add(map.voxel_m * (cell.array() + 0.5).matrix(), 1, 1.0F);
  }
}

}  // namespace swiftlet
