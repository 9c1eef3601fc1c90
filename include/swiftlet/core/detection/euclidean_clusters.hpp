// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/detection/clusterer.hpp"

namespace swiftlet {

/// Default clusterer. Points that are not finite, or farther than 500 000 tolerances from the origin, are ignored.
/// Exact to the rounding of single precision; about linear in the number of points, also for duplicates and dense
/// clusters. Reuses its memory from call to call. Any frame, the same for all arguments.
class EuclideanClusters : public Clusterer {
 public:
  void compute(std::span<const Eigen::Vector3f> points_m, double tolerance_m) override;

 private:
  struct Keyed {
    std::uint64_t key;  // key of the cell: z, y, x
    std::uint32_t point;
  };
  struct Cell {
    std::uint64_t key;
    std::uint32_t first, count;  // range of its points in keyed_
    Eigen::Vector3f min, max;    // bounding box of its points
  };

  void fill_cells(std::span<const Eigen::Vector3f> points, double tolerance_m);
  void join_cells(std::span<const Eigen::Vector3f> points, float tolerance_m);
  void collect(std::size_t num_points);
  bool are_near(std::span<const Eigen::Vector3f> points, const Cell& a, const Cell& b, float tolerance_m) const;
  std::uint32_t root(std::uint32_t cell);

  std::vector<Keyed> keyed_, scratch_;  // points sorted by cell
  std::vector<Cell> cells_;             // sorted by key
  std::vector<std::uint64_t> keys_;     // keys of the cells, contiguous for searching
  std::vector<std::uint32_t> parents_;  // union-find forest of cells
  std::vector<std::uint32_t> cell_of_;  // cell of each point
  std::vector<std::uint32_t> labels_;   // cluster of each root
};

}  // namespace swiftlet
