// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/guidance/half_space.hpp"
#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// [m] Tolerance of tests whether a plane cuts a cell, or a voxel lies beyond it; exceeds the rounding error of single
/// precision. Larger values test more planes, and drop voxels that touch the cell.
inline constexpr double kPlaneSlack_m = 1e-4;

/// Weighted centroids. In this file, `agent` is the frame with its origin at the agent and local axes.
struct CellCentroids {
  Vector3 sensing_agent_m = Vector3::Zero();      ///< c_S
  Vector3 partitioned_agent_m = Vector3::Zero();  ///< c_A; zero when A is empty
};

/// Cells S and A of one agent, sampled on a cubic lattice [Kamler 2025, sec. 2.4.1], in the agent's frame. The samples
/// are stored in rows along x, and a convex cut leaves an interval of every row. So a cut costs one division per row,
/// independent of the number of samples.
class RblCell {
 public:
  /// @param planar  a disc in the agent's horizontal plane instead of a ball
  RblCell(double radius_m, double step_m, bool planar);

  /// Resets S to the ball between two heights (2.4, 2.14), and A to S.
  /// @param lattice_agent_m  any point of the lattice; zero: the lattice is centered at the agent
  void reset(const Vector3& lattice_agent_m, double z_low_m, double z_high_m);

  /// Restricts A to the half-space (2.3).
  void cut(const HalfSpace& keep);

  /// Centroids with the weight exp(-|q - destination| / beta) (2.5, 2.10).
  CellCentroids centroids(const Vector3& destination_agent_m, double beta_m);
  /// Centroid of A with the same weight; cheaper.
  Vector3 partitioned_centroid(const Vector3& destination_agent_m, double beta_m);

  bool is_empty() const;                            ///< no sample is in A
  int num_samples() const { return num_samples_; }  ///< number of samples of S
  int num_partitioned() const;                      ///< number of samples of A
  Vector3 point(int sample) const { return at(first_sample_ + sample); }
  bool contains(int sample) const;  ///< whether the sample is in A
  /// Sample of A that is nearest to `wanted_agent_m`; -1 when A is empty.
  int nearest_partitioned(const Vector3& wanted_agent_m) const;
  /// Sample of S whose largest violation of a half-space is the smallest; replaces the centroid when A is empty.
  /// @param num_soft  number of soft half-spaces at the beginning; violations of the others weigh more
  Vector3 least_violating(const std::vector<HalfSpace>& cuts,
                          std::size_t num_soft = std::numeric_limits<std::size_t>::max()) const;
  double step_m() const { return step_m_; }
  double radius_m() const { return radius_m_; }

 private:
  struct Row {
    int first = 0, count = 0;  // range of the row's samples in x_, y_, z_
    int low = 0, high = 0;     // samples of the row in A: [low, high)
    float x0 = 0, y = 0, z = 0;
    float x0_steps = 0;  // x0 in lattice steps
  };
  struct Sums {
    double weight = 0.0;
    Vector3 moment_agent = Vector3::Zero();
  };

  void sample_ball(const Vector3& origin_agent_m);
  Vector3 at(int i) const { return {x_[i], y_[i], z_[i]}; }
  Vector3 centroid(const Sums& sums, const Vector3& destination_agent_m) const;

  double radius_m_, step_m_;
  bool planar_;
  Vector3 origin_m_ = Vector3::Zero();  // lattice point within half a step of the agent
  std::vector<Row> ball_;               // all rows for this origin, by height
  std::vector<Row> rows_;               // rows between the two heights
  int first_sample_ = 0, num_samples_ = 0;
  Vector3 low_m_ = Vector3::Zero(), high_m_ = Vector3::Zero();  // bounding box of A
  Eigen::ArrayXf x_, y_, z_;
  Eigen::ArrayXf weight_;
  Eigen::ArrayXf in_x_, in_y_, in_z_;  // samples of A, packed
};

}  // namespace swiftlet
