// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/separate_background.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet {
namespace {

bool bit(const std::uint64_t* words, int x) { return (words[x / 64] >> (x % 64)) & 1U; }

// Is there a pair of occupied cells, one of each row and one of each run, at most `reach` apart along x?
bool near(const std::uint64_t* a, int a_first, int a_last, const std::uint64_t* b, int b_first, int b_last, int reach) {
  for (int x = std::max(a_first, b_first - reach); x <= std::min(a_last, b_last + reach); ++x) {
    if (!bit(a, x)) continue;
    for (int y = std::max(x - reach, b_first); y <= std::min(x + reach, b_last); ++y) {
      if (bit(b, y)) return true;
    }
  }
  return false;
}

}  // namespace

const std::vector<std::ptrdiff_t>& SeparateBackground::find(const VoxelMap& map, double distance_m,
                                                            int least_confident) {
  const Cell size = map.grid().size;
  const double distance = distance_m / map.grid().edge_m * (1.0 + 1e-9);
  const int reach = static_cast<int>(std::floor(distance));
  fill_runs(map, reach);

  for (int z = 0; z < size.z(); ++z) {
    for (int y = 0; y < size.y(); ++y) {
      const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(z) * size.y() + y;
      if (row_start_[row] == row_start_[row + 1]) continue;
      // Half of the rows around it, because nearness is mutual.
      for (int dz = 0; dz <= reach && z + dz < size.z(); ++dz) {
        for (int dy = dz == 0 ? 1 : -reach; dy <= reach; ++dy) {
          const double left_sq = distance * distance - dy * dy - dz * dz;
          if (left_sq < 0.0 || y + dy < 0 || y + dy >= size.y()) continue;
          join_rows(map, row, row + static_cast<std::ptrdiff_t>(dz) * size.y() + dy,
                    static_cast<int>(std::sqrt(left_sq)));
        }
      }
    }
  }

  const auto for_each_voxel = [&](auto&& visit) {
    for (std::ptrdiff_t row = 0; row < map.num_rows(); ++row) {
      const std::uint64_t* words = map.row_bits(row);
      for (std::uint32_t run = row_start_[row]; run < row_start_[row + 1]; ++run) {
        const std::uint32_t cluster = root(run);
        for (int x = runs_[run].first; x <= runs_[run].last; ++x) {
          if (bit(words, x)) visit(cluster, row * size.x() + x);
        }
      }
    }
  };
  num_confident_.assign(runs_.size(), 0);
  for_each_voxel([&](std::uint32_t cluster, std::ptrdiff_t index) {
    num_confident_[cluster] += map.state(index) == VoxelState::kConfident;
  });
  const auto least = static_cast<std::uint32_t>(std::max(least_confident, 0));
  num_kept_ = 0;
  for (std::uint32_t run = 0; run < runs_.size(); ++run) {
    num_kept_ += root(run) == run && num_confident_[run] >= least;
  }
  separate_.clear();
  for_each_voxel([&](std::uint32_t cluster, std::ptrdiff_t index) {
    if (num_confident_[cluster] < least) separate_.push_back(index);
  });
  return separate_;
}

void SeparateBackground::fill_runs(const VoxelMap& map, int bridged) {
  runs_.clear();
  row_start_.assign(1, 0);
  for (std::ptrdiff_t row = 0; row < map.num_rows(); ++row) {
    const std::uint64_t* words = map.row_bits(row);
    for (int w = 0; w < map.words_per_row(); ++w) {
      for (std::uint64_t bits = words[w]; bits != 0; bits &= bits - 1) {
        const int x = 64 * w + __builtin_ctzll(bits);
        const bool goes_on = runs_.size() > row_start_.back() && x - runs_.back().last <= bridged;
        if (goes_on)
          runs_.back().last = x;
        else
          runs_.push_back({x, x});
      }
    }
    row_start_.push_back(static_cast<std::uint32_t>(runs_.size()));
  }
  parents_.resize(runs_.size());
  for (std::uint32_t i = 0; i < parents_.size(); ++i) parents_[i] = i;
}

// Runs of a row are in order, so the ones that can be near move forward together.
void SeparateBackground::join_rows(const VoxelMap& map, std::ptrdiff_t row, std::ptrdiff_t other, int reach) {
  const std::uint64_t *a_bits = map.row_bits(row), *b_bits = map.row_bits(other);
  std::uint32_t window = row_start_[other];
  for (std::uint32_t a = row_start_[row]; a < row_start_[row + 1]; ++a) {
    while (window < row_start_[other + 1] && runs_[window].last < runs_[a].first - reach) ++window;
    for (std::uint32_t b = window; b < row_start_[other + 1] && runs_[b].first <= runs_[a].last + reach; ++b) {
      if (root(a) == root(b)) continue;
      if (near(a_bits, runs_[a].first, runs_[a].last, b_bits, runs_[b].first, runs_[b].last, reach)) join(a, b);
    }
  }
}

std::uint32_t SeparateBackground::root(std::uint32_t run) {
  while (parents_[run] != run) {
    parents_[run] = parents_[parents_[run]];
    run = parents_[run];
  }
  return run;
}

void SeparateBackground::join(std::uint32_t a, std::uint32_t b) {
  a = root(a);
  b = root(b);
  parents_[std::max(a, b)] = std::min(a, b);
}

}  // namespace swiftlet
