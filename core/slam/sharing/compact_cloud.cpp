// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/sharing/compact_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/slam/cell_keys.hpp"
#include "core/slam/graph/closure_search.hpp"
#include "core/slam/matching/sweep.hpp"

namespace swiftlet {
namespace {

/// [levels] Depth of the octree: 256 voxels along each axis, beyond which points are dropped. A level more doubles the
/// extent and takes up to a byte more for each point.
constexpr int kTreeDepth = 8;
/// [voxels] Half of the octree along an axis: indices are relative to the origin of the frame.
constexpr int kHalfTree = 1 << (kTreeDepth - 1);

struct PackedPoint {
  std::uint32_t path = 0;    // three bits for each level of the octree, the topmost first
  std::uint32_t within = 0;  // position within the voxel: `bits` bits for each of x, y and z
};

/// Hash of the key of a column: the last steps of SplitMix64. A linear hash would select columns in a
/// pattern, and a wall along the pattern would lose all of them.
std::uint64_t hash_of(std::uint64_t key) {
  key = (key ^ key >> 30) * 0xBF58476D1CE4E5B9ULL;
  key = (key ^ key >> 27) * 0x94D049BB133111EBULL;
  return key ^ key >> 31;
}

int digit_of(std::uint32_t path, int level) { return static_cast<int>(path >> (3 * (kTreeDepth - 1 - level)) & 7U); }

/// Number of octree levels that two voxels share.
int shared_levels(std::uint32_t a, std::uint32_t b) {
  int level = 0;
  while (level < kTreeDepth && digit_of(a, level) == digit_of(b, level)) ++level;
  return level;
}

class BitWriter {
 public:
  void put(std::uint32_t value, int bits) {
    for (int i = bits - 1; i >= 0; --i) {
      if (free_ == 0) {
        bytes.push_back(0);
        free_ = 8;
      }
      --free_;
      bytes.back() = static_cast<std::uint8_t>(bytes.back() | ((value >> i & 1U) << free_));
    }
  }
  std::vector<std::uint8_t> bytes;

 private:
  int free_ = 0;  // unused bits of the last byte
};

class BitReader {
 public:
  explicit BitReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  std::uint32_t get(int bits) {
    if (next_ + static_cast<std::size_t>(bits) > 8 * bytes_.size()) {
      short_ = true;
      return 0;
    }
    std::uint32_t value = 0;
    for (int i = 0; i < bits; ++i, ++next_) value = value << 1 | (bytes_[next_ / 8] >> (7 - next_ % 8) & 1U);
    return value;
  }
  bool short_of_bits() const { return short_; }
  bool at_the_end() const { return 8 * bytes_.size() - next_ < 8; }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t next_ = 0;
  bool short_ = false;
};

void write_tree(std::span<const PackedPoint> points, int level, int bits, BitWriter& out) {
  if (level == kTreeDepth) {
    out.put(points.front().within, 3 * bits);
    return;
  }
  std::uint32_t mask = 0;
  for (const PackedPoint& p : points) mask |= 1U << digit_of(p.path, level);
  out.put(mask, 8);
  for (std::size_t first = 0, last = 0; first < points.size(); first = last) {
    while (last < points.size() && digit_of(points[last].path, level) == digit_of(points[first].path, level)) ++last;
    write_tree(points.subspan(first, last - first), level + 1, bits, out);
  }
}

/// False when the bytes end early, a branch is empty, or there are more than `most` points.
bool read_tree(BitReader& in, int level, std::uint32_t path, int bits, std::size_t most,
               std::vector<PackedPoint>& points) {
  if (level == kTreeDepth) {
    points.push_back({path, in.get(3 * bits)});
    return !in.short_of_bits() && points.size() <= most;
  }
  const std::uint32_t mask = in.get(8);
  if (in.short_of_bits() || mask == 0) return false;
  for (std::uint32_t child = 0; child < 8; ++child) {
    if ((mask >> child & 1U) != 0 && !read_tree(in, level + 1, path << 3 | child, bits, most, points)) return false;
  }
  return true;
}

}  // namespace

std::vector<Eigen::Vector3f> points_to_share_m(std::span<const Eigen::Vector3f> points_m,
                                               const CompactCloudConfig& config, double range_max_m) {
  std::vector<Eigen::Vector3f> shared_m = upright_points_m(points_m, config.voxel_m, range_max_m);
  // Keeps one in one_in columns whole, so that upright structure can be detected in the rest.
  const std::size_t one_in = shared_m.size() / static_cast<std::size_t>(config.upright_points) + 1;
  std::erase_if(shared_m, [&](const Eigen::Vector3f& p) {
    const auto index = [&](float x_m) {
      return static_cast<std::int64_t>(std::floor(static_cast<double>(x_m) / config.voxel_m));
    };
    return hash_of(cell_key(index(p.x()), index(p.y()), 0)) % one_in != 0;
  });
  std::vector<Eigen::Vector3f> all_m;
  all_m.reserve(points_m.size());
  for (const Eigen::Vector3f& p : points_m) {
    if (p.head<2>().norm() <= static_cast<float>(range_max_m)) all_m.push_back(p);
  }
  std::vector<std::uint32_t> kept;
  VoxelThinner().thin(all_m, static_cast<float>(config.flat_voxel_m), kept);
  for (const std::uint32_t i : kept) shared_m.push_back(all_m[i]);
  return shared_m;
}

std::vector<PackedPoints> pack_points(std::span<const Eigen::Vector3f> points_m, double voxel_m, int bits,
                                      int most_bytes) {
  std::vector<PackedPoint> points;
  points.reserve(points_m.size());
  const int steps = 1 << bits;
  for (const Eigen::Vector3f& p : points_m) {
    const Vector3 at = p.cast<double>() / voxel_m;
    const Vector3 floor = at.array().floor();
    if (!(floor.minCoeff() >= -kHalfTree && floor.maxCoeff() < kHalfTree)) continue;
    PackedPoint packed;
    for (int level = kTreeDepth - 1; level >= 0; --level) {
      for (int axis = 0; axis < 3; ++axis) {
        const auto cell = static_cast<std::uint32_t>(static_cast<int>(floor[axis]) + kHalfTree);
        packed.path = packed.path << 1 | (cell >> level & 1U);
      }
    }
    for (int axis = 0; axis < 3; ++axis) {
      const int step = std::clamp(static_cast<int>((at[axis] - floor[axis]) * steps), 0, steps - 1);
      packed.within = packed.within << bits | static_cast<std::uint32_t>(step);
    }
    points.push_back(packed);
  }
  std::stable_sort(points.begin(), points.end(),
                   [](const PackedPoint& a, const PackedPoint& b) { return a.path < b.path; });
  points.erase(std::unique(points.begin(), points.end(),
                           [](const PackedPoint& a, const PackedPoint& b) { return a.path == b.path; }),
               points.end());

  std::vector<PackedPoints> parts;
  for (std::size_t first = 0, last = 0; first < points.size(); first = last) {
    int size_bits = 0;
    for (; last < points.size() && last - first < std::numeric_limits<std::uint16_t>::max(); ++last) {
      const int shared = last == first ? -1 : shared_levels(points[last - 1].path, points[last].path);
      const int more_bits = 8 * (kTreeDepth - 1 - shared) + 3 * bits;
      if (last > first && size_bits + more_bits > 8 * most_bytes) break;
      size_bits += more_bits;
    }
    BitWriter out;
    write_tree(std::span(points).subspan(first, last - first), 0, bits, out);
    parts.push_back({static_cast<std::uint16_t>(last - first), std::move(out.bytes)});
  }
  return parts;
}

bool unpack_points(std::span<const std::uint8_t> data, int num_points, double voxel_m, int bits,
                   std::vector<Eigen::Vector3f>& points_submap_m) {
  if (num_points < 1 || bits < 1 || bits > 10) return false;
  BitReader in(data);
  std::vector<PackedPoint> points;
  const auto num = static_cast<std::size_t>(num_points);
  if (!read_tree(in, 0, 0, bits, num, points) || points.size() != num || !in.at_the_end()) return false;
  const double step_m = voxel_m / (1 << bits);
  points_submap_m.reserve(points_submap_m.size() + num);
  for (const PackedPoint& packed : points) {
    Vector3 p_m;
    for (int axis = 0; axis < 3; ++axis) {
      int cell = 0;
      for (int level = 0; level < kTreeDepth; ++level) {
        cell = cell << 1 | (digit_of(packed.path, level) >> (2 - axis) & 1);
      }
      const auto within = packed.within >> (bits * (2 - axis)) & ((1U << bits) - 1U);
      p_m[axis] = voxel_m * (cell - kHalfTree) + step_m * (within + 0.5);
    }
    points_submap_m.push_back(p_m.cast<float>());
  }
  return true;
}

}  // namespace swiftlet
