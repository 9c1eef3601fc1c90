// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <map>
#include <unordered_map>
#include <vector>

#include "swiftlet/core/base/detection.hpp"
#include "swiftlet/core/detection/vofod_config.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"

/// Reference implementation of VoFOD, the detector of Vrba 2025, written from the paper, with its interpretations and
/// the parameters of Table II. Double precision, independent of core/detection, core/map and the ray traversal, whose
/// results and run times are compared with it.
namespace swiftlet::reference {

/// Voxel traversal of Amanatides and Woo (1987): calls visit(cell, length of the ray in the cell [m]) along the ray.
template <class Visit>
void walk(const Vector3& origin_m, const Vector3& direction, double length_m, double edge_m, Visit&& visit) {
  Eigen::Vector3i cell = (origin_m / edge_m).array().floor().cast<int>();
  Eigen::Vector3i step;
  Vector3 t_next, t_delta;
  for (int a = 0; a < 3; ++a) {
    step[a] = direction[a] > 0.0 ? 1 : -1;
    if (direction[a] == 0.0) {
      t_next[a] = t_delta[a] = std::numeric_limits<double>::infinity();
      continue;
    }
    const double plane_m = (cell[a] + (direction[a] > 0.0 ? 1 : 0)) * edge_m;
    t_next[a] = (plane_m - origin_m[a]) / direction[a];
    t_delta[a] = edge_m / std::abs(direction[a]);
  }
  for (double t = 0.0; t < length_m;) {
    int a = 0;
    const double next = std::min(t_next.minCoeff(&a), length_m);
    if (next > t) visit(cell, next - t);
    t = next;
    cell[a] += step[a];
    t_next[a] += t_delta[a];
  }
}

/// Voxel map of VoFOD: occupancy value G of each voxel, in a dense array.
struct Map {
  explicit Map(const VoxelMapConfig& config) : config(config) {
    min_cell = ((config.center_m - 0.5 * config.size_m) / config.voxel_m).array().floor().cast<int>();
    const Eigen::Vector3i end = ((config.center_m + 0.5 * config.size_m) / config.voxel_m).array().ceil().cast<int>();
    size = end - min_cell;
    G.assign(static_cast<std::size_t>(size.x()) * size.y() * size.z(), config.g_unknown);
  }
  Eigen::Vector3i cell_of(const Vector3& p_m) const { return (p_m / config.voxel_m).array().floor().cast<int>(); }
  Vector3 center_m(const Eigen::Vector3i& cell) const { return (cell.cast<double>().array() + 0.5) * config.voxel_m; }
  bool contains(const Eigen::Vector3i& cell) const {
    return ((cell - min_cell).array() >= 0).all() && ((cell - min_cell).array() < size.array()).all();
  }
  bool contains(const Vector3& p_m) const { return (p_m.array().abs() < 1e6).all() && contains(cell_of(p_m)); }
  std::size_t index(const Eigen::Vector3i& cell) const {
    const Eigen::Vector3i at = cell - min_cell;
    return (static_cast<std::size_t>(at.z()) * size.y() + at.y()) * size.x() + at.x();
  }
  Eigen::Vector3i cell(std::size_t i) const {
    return min_cell + Eigen::Vector3i(static_cast<int>(i % size.x()), static_cast<int>(i / size.x() % size.y()),
                                      static_cast<int>(i / size.x() / size.y()));
  }
  double& at(const Eigen::Vector3i& cell) { return G[index(cell)]; }
  /// Moves voxel i toward g by n observations, eq. (12); at infinite n to g.
  void update(std::size_t i, double n, double g) {
    G[i] = std::isinf(n) ? g : std::exp2(-n) * G[i] + (1.0 - std::exp2(-n)) * g;
  }

  VoxelMapConfig config;
  Eigen::Vector3i min_cell, size;
  std::vector<double> G;
};

struct CellHash {
  std::size_t operator()(const Eigen::Vector3i& c) const {
    return static_cast<std::size_t>(c.x()) * 73856093U ^ static_cast<std::size_t>(c.y()) * 19349663U ^
           static_cast<std::size_t>(c.z()) * 83492791U;
  }
};

/// Euclidean clusters as in PCL: breadth-first search, neighbors from a hash grid of cells of the tolerance's size.
inline std::vector<std::vector<int>> clusters(const std::vector<Vector3>& points, double tolerance_m) {
  std::unordered_map<Eigen::Vector3i, std::vector<int>, CellHash> buckets;
  const auto bucket_of = [&](const Vector3& p) -> Eigen::Vector3i {
    return (p / tolerance_m).array().floor().cast<int>();
  };
  for (int i = 0; i < static_cast<int>(points.size()); ++i) buckets[bucket_of(points[i])].push_back(i);
  std::vector<std::vector<int>> out;
  std::vector<char> done(points.size(), 0);
  for (int seed = 0; seed < static_cast<int>(points.size()); ++seed) {
    if (done[seed]) continue;
    done[seed] = 1;
    std::vector<int>& cluster = out.emplace_back(1, seed);
    for (std::size_t k = 0; k < cluster.size(); ++k) {
      const Vector3 p = points[cluster[k]];
      const Eigen::Vector3i b = bucket_of(p);
      for (int z = -1; z <= 1; ++z) {
        for (int y = -1; y <= 1; ++y) {
          for (int x = -1; x <= 1; ++x) {
            const auto found = buckets.find(b + Eigen::Vector3i(x, y, z));
            if (found == buckets.end()) continue;
            for (const int j : found->second) {
              if (done[j] || (points[j] - p).norm() > tolerance_m) continue;
              done[j] = 1;
              cluster.push_back(j);
            }
          }
        }
      }
    }
  }
  return out;
}

/// Stages of the detector for one scan: classify(), cast_rays(), then remove_separate().
class Vofod {
 public:
  explicit Vofod(const VofodConfig& config) : map(config.map), config_(config) {}

  /// Clusters the cloud, classifies the clusters and updates their voxels, sec. III-B. Returns the flying ones. Sets
  /// `classes`.
  std::vector<Detection> classify(const LocalCloud& cloud) {
    std::vector<Vector3> points;
    for (const Eigen::Vector3f& p : cloud.points_local_m) {
      if (map.contains(Vector3(p.cast<double>()))) points.push_back(p.cast<double>());
    }
    const auto found = clusters(points, config_.cluster_distance_m);
    classes.assign(found.size(), 1);
    std::vector<Detection> detections;
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (rule_a(points, found[i])) {
        classes[i] = 0;
      } else if (found[i].size() >= kMinPoints && diagonal_m(points, found[i]) <= config_.max_size_m &&
                 rule_b(points, found[i])) {
        classes[i] = 2;
        Detection d;
        for (const int p : found[i]) d.position_m += points[p];
        d.position_m /= static_cast<double>(found[i].size());  // eq. (19)
        d.num_points = static_cast<int>(found[i].size());
        detections.push_back(d);
      } else if (diagonal_m(points, found[i]) > config_.max_size_m) {
        classes[i] = 3;  // too large to fly: its voxels become background
      }
    }
    std::vector<std::size_t> order(found.size());  // eqs. (16) to (18): background first, too large clusters last
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_partition(order.begin(), order.end(), [&](std::size_t i) { return classes[i] == 0; });
    std::stable_partition(order.begin(), order.end(), [&](std::size_t i) { return classes[i] != 3; });
    for (const std::size_t i : order) {
      std::map<std::size_t, int> counts;
      for (const int p : found[i]) ++counts[map.index(map.cell_of(points[p]))];
      for (const auto& [voxel, n] : counts) {
        const double infinity = std::numeric_limits<double>::infinity();
        map.update(voxel, classes[i] >= 2 ? infinity : n,
                   classes[i] == 0 || classes[i] == 3 ? config_.map.g_occupied : config_.map.g_unknown);
      }
    }
    return detections;
  }

  /// Moves the voxels along the rays toward free, by the length of the rays in each voxel, sec. III-C, eqs. (20) to
  /// (22).
  void cast_rays(const LocalCloud& cloud, int num_classifications) {
    const Scan& scan = *cloud.scan;
    lengths.assign(map.G.size(), 0.0);
    for (int i = 0; i < scan.size(); ++i) {
      if (!scan.beams->masked.empty() && scan.beams->masked[i]) continue;
      const Pose& T = cloud.T_local_lidar[i % scan.cols()];
      const Vector3 direction = T.linear() * scan.beams->directions_lidar[i].cast<double>();
      const double length_m = scan.hit(i) ? std::min<double>(config_.ray_max_m, scan.range_m[i]) : config_.ray_max_m;
      walk(T * scan.beams->origins_lidar[i].cast<double>(), direction, length_m, config_.map.voxel_m,
           [&](const Eigen::Vector3i& cell, double length) {
             if (map.contains(cell)) lengths[map.index(cell)] += length;
           });
    }
    for (std::size_t i = 0; i < lengths.size(); ++i) {
      if (lengths[i] == 0.0) continue;
      const double n =
          num_classifications * config_.ray_weight * std::sqrt(3.0) / (3.0 * config_.map.voxel_m) * lengths[i];
      map.update(i, n, config_.map.g_free);
    }
  }

  /// Removes small separate clusters of background from the map, sec. III-D, eqs. (23) to (25).
  void remove_separate(int num_classifications) {
    std::vector<std::size_t> voxels;
    std::vector<Vector3> centers;
    for (std::size_t i = 0; i < map.G.size(); ++i) {
      if (map.G[i] < config_.map.G_tentative) continue;
      voxels.push_back(i);
      centers.push_back(map.center_m(map.cell(i)));
    }
    for (const auto& cluster : clusters(centers, kSeparate_m)) {
      const auto confident = std::count_if(cluster.begin(), cluster.end(),
                                           [&](int k) { return map.G[voxels[k]] >= config_.map.G_confident; });
      if (confident >= config_.separate_min_confident) continue;
      const double g = config_.choices.separate_becomes == VofodChoices::SeparateBecomes::kFree ? config_.map.g_free
                                                                                                : config_.map.g_unknown;
      for (const int k : cluster) map.update(voxels[k], num_classifications, g);
    }
  }

  Map map;
  std::vector<int> classes;     // class of each cluster: 0 background, 1 unknown, 2 flying, 3 too large to fly
  std::vector<double> lengths;  // length of the last scan's rays in each voxel [m]

 private:
  static constexpr std::size_t kMinPoints = 2;  // [-] minimum number of points of a detection
  static constexpr double kSeparate_m = 0.7;    // [m] d_sep: largest gap within a cluster of background

  /// Rule A: true when a point is within close_distance_m of background in the map.
  bool rule_a(const std::vector<Vector3>& points, const std::vector<int>& cluster) {
    const int reach = static_cast<int>(std::ceil(config_.close_distance_m / config_.map.voxel_m));
    for (const int i : cluster) {
      const Eigen::Vector3i at = map.cell_of(points[i]);
      for (int z = -reach; z <= reach; ++z) {
        for (int y = -reach; y <= reach; ++y) {
          for (int x = -reach; x <= reach; ++x) {
            const Eigen::Vector3i cell = at + Eigen::Vector3i(x, y, z);
            if (!map.contains(cell) || map.at(cell) < config_.map.G_tentative) continue;
            if ((map.center_m(cell) - points[i]).norm() <= config_.close_distance_m) return true;
          }
        }
      }
    }
    return false;
  }

  /// Rule B, Algorithm 1: true when free voxels enclose the cluster within search_distance_m.
  bool rule_b(const std::vector<Vector3>& points, const std::vector<int>& cluster) {
    for (const int i : cluster) {
      const Eigen::Vector3i start = map.cell_of(points[i]);
      std::unordered_map<Eigen::Vector3i, bool, CellHash> visited;
      std::deque<Eigen::Vector3i> queue = {start};
      visited[start] = true;
      while (!queue.empty()) {
        const Eigen::Vector3i cell = queue.front();
        queue.pop_front();
        if (!map.contains(cell)) return false;
        if (map.at(cell) >= config_.map.G_tentative) return false;
        if (map.at(cell) < config_.map.G_uncertain) continue;
        if (config_.map.voxel_m * (cell - start).cast<double>().norm() >= config_.search_distance_m) return false;
        for (int a = 0; a < 6; ++a) {
          Eigen::Vector3i next = cell;
          next[a / 2] += a % 2 == 0 ? 1 : -1;
          if (!visited[next]) {
            visited[next] = true;
            queue.push_back(next);
          }
        }
      }
    }
    return true;
  }

  /// Diagonal of the bounding box of a cluster along its principal axes.
  static double diagonal_m(const std::vector<Vector3>& points, const std::vector<int>& cluster) {
    Vector3 mean = Vector3::Zero();
    for (const int i : cluster) mean += points[i];
    mean /= static_cast<double>(cluster.size());
    Matrix3 scatter = Matrix3::Zero();
    for (const int i : cluster) scatter += (points[i] - mean) * (points[i] - mean).transpose();
    const Matrix3 axes = Eigen::SelfAdjointEigenSolver<Matrix3>(scatter).eigenvectors();
    Eigen::AlignedBox3d box;
    for (const int i : cluster) box.extend(Vector3(axes.transpose() * (points[i] - mean)));
    return box.sizes().norm();
  }

  VofodConfig config_;
};

}  // namespace swiftlet::reference
