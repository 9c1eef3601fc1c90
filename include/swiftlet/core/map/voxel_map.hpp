// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/map/background_query.hpp"
#include "swiftlet/core/map/voxel_grid.hpp"
#include "swiftlet/core/map_voxels.hpp"
#include "swiftlet/core/prior_map.hpp"

namespace swiftlet {

/// States of eq. (7), by growing confidence of occupancy.
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

/// The map M: a value G for every voxel of a box, dense. Beside the values it keeps one bit for each voxel that is at
/// least tentative, which makes the questions about what is occupied cheap. Any frame, the same for all arguments.
class VoxelMap : public BackgroundQuery {
 public:
  explicit VoxelMap(const VoxelMapConfig& config);

  const VoxelMapConfig& config() const { return config_; }
  const VoxelGrid& grid() const { return grid_; }

  // Values. What is outside is unknown.
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
  /// Eq. (12): n updates towards g, for any real n >= 0; infinity sets the value to g.
  void update(std::ptrdiff_t index, double n, double g);
  void set(std::ptrdiff_t index, float value);
  /// update(index, n, g_free) for a row of voxels along x; n = 0 leaves one alone.
  void move_to_free(const Cell& first, std::span<const float> n);
  /// Sec. III-E: occupied voxels become +infinity, free ones -infinity; where both are claimed, occupied.
  void set_prior(const PriorMap& prior);
  std::size_t num_prior() const { return prior_free_.size() + prior_occupied_.size(); }
  /// Voxels of the prior that the map has no room for. A scrolling map comes to them, so there it is all of them or
  /// none: all until the first one enters.
  std::size_t num_prior_outside() const { return num_prior_outside_; }
  /// A scrolling map follows the vehicle: what leaves the box is forgotten, what enters is unknown (or prior).
  void follow(const Vector3& p_m);
  void clear();

  // Questions about voxels that are at least tentative occupied.
  bool occupied(std::ptrdiff_t index) const { return values_[index] >= G_tentative_; }
  std::ptrdiff_t num_occupied() const;
  /// Centers in the order of their indices.
  void append_centers(VoxelState at_least, std::vector<Vector3>& centers) const;
  /// A copy of all voxels but those that are exactly unknown, by their indices. Values are G.
  void append_voxels(MapVoxels& copy) const;
  /// Is the center of one within the radius of a point?
  bool occupied_within(const Vector3& p_m, double radius_m) const override {
    return any_within(p_m, radius_m, VoxelState::kTentative);
  }
  /// The same of a state that is at least tentative.
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

  // The bits: rows along x, row = z * size.y + y; bit i of a row is cell min_cell.x + i.
  int words_per_row() const { return words_per_row_; }
  std::ptrdiff_t num_rows() const { return static_cast<std::ptrdiff_t>(grid_.size.y()) * grid_.size.z(); }
  const std::uint64_t* row_bits(std::ptrdiff_t row) const { return bits_.data() + row * words_per_row_; }

 private:
  void stamp_prior();
  void rebuild_bits();
  std::uint64_t bits_of(std::ptrdiff_t row, int word) const;
  void set_bit(std::ptrdiff_t index, bool occupied);
  /// Calls visit(x) for the occupied cells of a row between two cells, in order, until it says no.
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
