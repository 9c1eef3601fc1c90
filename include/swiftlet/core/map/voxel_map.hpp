// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/map_voxels.hpp"
#include "swiftlet/core/base/prior_map.hpp"
#include "swiftlet/core/map/background_query.hpp"
#include "swiftlet/core/map/voxel_grid.hpp"

namespace swiftlet {

/// States of eq. (7), in order of increasing confidence of occupancy.
enum class VoxelState : std::uint8_t { kFree, kUncertain, kTentative, kConfident };

/// Multi-state occupancy map [Vrba 2025, sec. III-A]; the defaults are Table II.
struct VoxelMapConfig {
  double voxel_m = 0.25;
  double g_occupied = 0.0;
  double g_unknown = -740.0;
  double g_free = -1000.0;
  double G_confident = -0.1;
  double G_tentative = -300.0;
  double G_uncertain = -750.0;
  enum class Extent { kScrolling, kBounded };
  Extent extent = Extent::kScrolling;
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d size_m = {80.0, 80.0, 30.0};

  void visit(ConfigVisitor& v);
};

/// The map M: a value G for every voxel of a box, dense. A bit set of the voxels that are at least tentative
/// accelerates occupancy queries. Any frame, the same for all arguments.
class VoxelMap : public BackgroundQuery {
 public:
  explicit VoxelMap(const VoxelMapConfig& config);

  const VoxelMapConfig& config() const { return config_; }
  const VoxelGrid& grid() const { return grid_; }

  // Values. Voxels outside of the box are unknown.
  float value(std::ptrdiff_t index) const { return values_[index]; }
  float value_at(const Cell& cell) const { return grid_.contains(cell) ? values_[grid_.index(cell)] : g_unknown_; }
  VoxelState state_of(float value) const {
    if (value >= G_confident_) return VoxelState::kConfident;
    if (value >= G_tentative_) return VoxelState::kTentative;
    return value >= G_uncertain_ ? VoxelState::kUncertain : VoxelState::kFree;
  }
  VoxelState state(std::ptrdiff_t index) const { return state_of(value(index)); }
  VoxelState state_at(const Vector3& p_m) const;

  // Updates. Voxels of the prior map (+-infinity) never change.
  /// Eq. (12): n updates toward g, for any real n >= 0; infinity sets the value to g.
  void update(std::ptrdiff_t index, double n, double g);
  void set(std::ptrdiff_t index, float value);
  /// Calls update(index, n, g_free) for a row of voxels along x; voxels with n = 0 keep their values.
  void move_to_free(const Cell& first, std::span<const float> n);
  /// Sec. III-E: occupied voxels become +infinity, free ones -infinity; occupied takes precedence.
  void set_prior(const PriorMap& prior);
  std::size_t num_prior() const { return prior_free_.size() + prior_occupied_.size(); }
  /// Number of prior voxels that do not fit into the map. A scrolling map reaches them later, so there it is all of
  /// them until the first one enters the box, and 0 from then on.
  std::size_t num_prior_outside() const { return num_prior_outside_; }
  /// Scrolls the box with the vehicle: voxels that leave are dropped, voxels that enter are unknown (or prior).
  void follow(const Vector3& p_m);
  void clear();

  // Queries of voxels that are at least tentative.
  bool occupied(std::ptrdiff_t index) const { return values_[index] >= G_tentative_; }
  std::ptrdiff_t num_occupied() const;
  /// Appends centers in the order of their indices.
  void append_centers(VoxelState at_least, std::vector<Vector3>& centers) const;
  /// Appends a copy of all voxels except those with the unknown value, by index. Values are G.
  void append_voxels(MapVoxels& copy) const;
  /// True when the center of such a voxel is within the radius of a point.
  bool occupied_within(const Vector3& p_m, double radius_m) const override {
    return any_within(p_m, radius_m, VoxelState::kTentative);
  }
  /// True when the center of a voxel of at least this state, which is at least tentative, is within the radius.
  bool any_within(const Vector3& p_m, double radius_m, VoxelState at_least) const;
  /// Calls visit(index) for each, in the order of their indices.
  template <class Visit>
  void for_each_occupied(Visit&& visit) const {
    for (std::ptrdiff_t row = 0; row < num_rows(); ++row) {
      const std::uint64_t* words = row_bits(row);
      for (int w = 0; w < words_per_row_; ++w) {
        for (std::uint64_t bits = words[w]; bits != 0; bits &= bits - 1) {
          visit(row * grid_.size.x() + 64 * w + __builtin_ctzll(bits));
        }
      }
    }
  }

  // Bit set: rows along x, row = z * size.y + y; bit i of a row is cell min_cell.x + i.
  int words_per_row() const { return words_per_row_; }
  std::ptrdiff_t num_rows() const { return static_cast<std::ptrdiff_t>(grid_.size.y()) * grid_.size.z(); }
  const std::uint64_t* row_bits(std::ptrdiff_t row) const { return bits_.data() + row * words_per_row_; }

 private:
  void stamp_prior();
  void rebuild_bits();
  std::uint64_t bits_of(std::ptrdiff_t row, int word) const;
  void set_bit(std::ptrdiff_t index, bool occupied);
  /// Calls visit(x) for the occupied cells of a row between two cells, in order, until it returns false.
  template <class Visit>
  bool visit_row(std::ptrdiff_t row, int x_first, int x_last, Visit&& visit) const;
  template <class Visit>
  void visit_box(const Vector3& p_m, double radius_m, Visit&& visit) const;

  VoxelMapConfig config_;
  VoxelGrid grid_;
  float g_unknown_, G_confident_, G_tentative_, G_uncertain_;
  int words_per_row_ = 0;
  std::vector<float> values_;
  std::vector<std::uint64_t> bits_;
  std::vector<Cell> prior_free_, prior_occupied_;
  std::size_t num_prior_outside_ = 0;
};

}  // namespace swiftlet
