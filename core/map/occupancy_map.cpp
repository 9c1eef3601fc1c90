// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/map/occupancy_map.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "core/map/block_log.hpp"
#include "core/map/block_occupancy.hpp"
#include "core/map/cell_walk.hpp"
#include "core/map/distance_tiles.hpp"
#include "core/map/log_odds_blocks.hpp"
#include "core/map/occupied_changes.hpp"
#include "core/map/ray_cells.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {
namespace {

/// Constants of the occupancy map.
struct OccupancyMapConstants {
  /// Number of scans whose times are kept. Cells that were hit last in an older scan count as never hit.
  static constexpr std::size_t kScanTimes = 4096;
  /// [-] share of a block by which the vehicle has moved when blocks are dropped. Larger values save time, and keep
  /// blocks longer.
  static constexpr double kKeepStep = 0.25;
};
using MapConstants = OccupancyMapConstants;

float log_odds_of(double p) { return static_cast<float>(elementary::log(p / (1.0 - p))); }

/// As OcTree::updateNodeLogOdds.
float moved(float log_odds, float by, float min, float max) {
  log_odds += by;
  return log_odds < min ? min : log_odds > max ? max : log_odds;
}

LogOddsBlocks::AfterMisses log_odds_after_misses(float miss, float min, float max) {
  LogOddsBlocks::AfterMisses after_misses{};
  for (std::size_t n = 1; n < after_misses.size(); ++n) after_misses[n] = moved(after_misses[n - 1], miss, min, max);
  return after_misses;
}

class LogOddsMap final : public BlockOccupancy<OccupancyMap> {
 public:
  explicit LogOddsMap(const OccupancyMapConfig& config);

  CellState state(const Vector3& p_local_m) const override { return state_of(cell_of(p_local_m)); }
  void occupied_within(const Vector3& center_local_m, double radius_m, TimeNs since,
                       std::vector<Vector3>& centers_local_m) const override;
  bool changed_since(std::uint64_t revision, std::vector<VoxelGrid>& boxes) const override;
  void append_voxels(MapVoxels& copy) const override;

  void insert(std::span<const Ray> rays, TimeNs now) override;
  void keep_around(const Vector3& center_local_m) override;
  bool look_at(const Cell& block, CellBlock& states) const override;
  std::vector<CellBlock> blocks_above(double p) const override;
  float log_odds(const Cell& cell) const override;
  bool known(const Cell& cell) const override { return state_of(cell) != CellState::kUnknown; }
  std::size_t num_blocks() const override { return blocks_.num_used(); }

 private:
  using Block = LogOddsBlocks::Block;
  using Page = LogOddsBlocks::Page;

  int find_or_make(const Cell& block);
  void forget(int block);
  void miss(int i, const Bits& passed);
  void miss_valued(int i, int z, std::uint64_t cells);
  void hit(const Cell& cell);
  CellState state_of(const Cell& cell) const;
  const Bits* occupied_of(const Cell& block) const override;
  void append_changes(const Cell& low, const Cell& high, std::uint64_t since,
                      std::vector<Change>& changes) const override {
    changes_.append(blocks_, low, high, since, changes);
  }

  OccupancyMapConfig config_;
  float hit_, miss_, occupied_, min_, max_;  // log-odds
  LogOddsBlocks::AfterMisses after_misses_;
  int most_misses_ = 0;  // miss count at which the log-odds are clamped or a value is needed
  RayCells rays_;
  LogOddsBlocks blocks_;
  OccupiedChanges changes_;
  std::uint32_t scan_ = 0;
  std::vector<TimeNs> scan_times_;  // times of the last scans, in a ring buffer
  BlockLog removed_;
  Vector3 kept_around_local_m_;
};

LogOddsMap::LogOddsMap(const OccupancyMapConfig& config)
    : BlockOccupancy(config.edge_m,
                     std::min(config.distance_max_m, OccupancyMapConfig::kMaxDistance_cells * config.edge_m)),
      config_(config),
      hit_(log_odds_of(config.p_hit)),
      miss_(log_odds_of(config.p_miss)),
      occupied_(log_odds_of(config.p_occupied)),
      min_(log_odds_of(OccupancyMapConfig::kProbabilityMin)),
      max_(log_odds_of(OccupancyMapConfig::kProbabilityMax)),
      after_misses_(log_odds_after_misses(miss_, min_, max_)),
      rays_(config.edge_m),
      blocks_(config.places_across(), after_misses_),
      changes_(blocks_.num_places()),
      scan_times_(MapConstants::kScanTimes, std::numeric_limits<TimeNs>::min()),
      kept_around_local_m_(Vector3::Constant(std::numeric_limits<double>::infinity())) {
  for (int n = 1; n <= LogOddsBlocks::kMaxMisses; ++n) {
    if (after_misses_[n] != after_misses_[n - 1]) most_misses_ = n;
  }
}

// Blocks

int LogOddsMap::find_or_make(const Cell& block) {
  const int i = blocks_.in_place_of(block);
  if (i >= 0 && blocks_.about(i).at == block) return i;
  // A block in the same slot lies beyond the kept radius.
  if (i >= 0) forget(i);
  return blocks_.make(block);
}

void LogOddsMap::forget(int i) {
  removed_.note(revision_, blocks_.about(i).at);
  blocks_.block(i).occupied = {};
  changes_.note_removed(blocks_, i, revision_);
  blocks_.remove(i);
}

void LogOddsMap::keep_around(const Vector3& center_local_m) {
  // Blocks are dropped whole: nothing changes until the vehicle has moved by a part of a block.
  const double block_m = kSide * config_.edge_m;
  if ((center_local_m - kept_around_local_m_).norm() < MapConstants::kKeepStep * block_m) return;
  kept_around_local_m_ = center_local_m;
  const auto far_away = [&](const Cell& at) {
    const Vector3 middle_local_m = (at.cast<double>().array() + 0.5) * block_m;
    return (middle_local_m - center_local_m).squaredNorm() > config_.keep_radius_m * config_.keep_radius_m;
  };
  bool removes = false;
  for (int i = 0; i < blocks_.size(); ++i) {
    if (!blocks_.about(i).used || !far_away(blocks_.about(i).at)) continue;
    if (!removes) ++revision_;
    removes = true;
    forget(i);
  }
  if (removes) distances_.forget_if(far_away);
}

// Updates

void LogOddsMap::insert(std::span<const Ray> rays, TimeNs now) {
  changes_.begin_scan(blocks_, revision_);
  ++scan_;
  ++revision_;
  scan_times_[scan_ % MapConstants::kScanTimes] = now;
  Eigen::AlignedBox3f origins_local_m;
  for (const Ray& ray : rays) {
    if (ray.origin_local_m.allFinite()) origins_local_m.extend(ray.origin_local_m);
  }
  rays_.begin(origins_local_m.cast<double>(), config_.range_max_m + config_.edge_m);
  for (const Ray& ray : rays) {
    const Eigen::Vector3f displacement = ray.end_local_m - ray.origin_local_m;
    const double length_m =
        std::sqrt(static_cast<double>(displacement.x() * displacement.x() + displacement.y() * displacement.y() +
                                      displacement.z() * displacement.z()));
    if (length_m <= config_.range_max_m) {
      rays_.add(ray.origin_local_m, ray.end_local_m, ray.hit);
    } else {
      const Eigen::Vector3f direction = displacement / static_cast<float>(length_m);
      rays_.add(ray.origin_local_m, ray.origin_local_m + direction * static_cast<float>(config_.range_max_m), false);
    }
  }
  rays_.take_passed([&](const Cell& block, const Bits& passed) {
    if (miss_ < 0.0F) miss(find_or_make(block), passed);
  });
  for (const Cell& cell : rays_.ends()) hit(cell);
}

void LogOddsMap::miss(int i, const Bits& passed) {
  Block& b = blocks_.block(i);
  std::uint64_t fresh = 0;
  const bool counted_to_the_end = after_misses_.back() == min_;
  for (int z = 0; z < kSide; ++z) {
    const std::uint64_t cells = passed[z];
    if (cells == 0) continue;
    if (const std::uint64_t valued = cells & b.valued[z]; valued != 0) miss_valued(i, z, valued);
    std::uint64_t counted = cells & ~b.valued[z];
    // Cells whose counter is full, or that further misses no longer change.
    const std::uint64_t most = b.with_misses(z, most_misses_) & counted;
    if (most != 0 && !counted_to_the_end) {
      blocks_.give_values(i, z, most);
      miss_valued(i, z, most);
    }
    counted &= ~most;
    fresh |= counted & b.with_misses(z, 0);
    b.count_misses(z, counted);
  }
  if (fresh != 0) blocks_.about(i).changed = revision_;
}

void LogOddsMap::miss_valued(int i, int z, std::uint64_t cells) {
  Page& values = blocks_.page(i);
  std::uint64_t& occupied = blocks_.block(i).occupied[z];
  const std::uint64_t before = occupied;
  for (std::uint64_t left = cells; left != 0; left &= left - 1) {
    const int bit = std::countr_zero(left);
    float& log_odds = values.log_odds[z << 6 | bit];
    log_odds = moved(log_odds, miss_, min_, max_);
    if (log_odds < occupied_) occupied &= ~(std::uint64_t{1} << bit);
  }
  if (occupied == before) return;
  blocks_.about(i).changed = revision_;
  changes_.note(blocks_, i, z, occupied ^ before, revision_);
}

void LogOddsMap::hit(const Cell& cell) {
  const int i = find_or_make(block_of(cell)), in_block = index_in_block(cell), z = in_block >> 6;
  const std::uint64_t bit = std::uint64_t{1} << (in_block & 63);
  Block& b = blocks_.block(i);
  if ((b.valued[z] & bit) == 0) {
    if (b.misses(z, in_block & 63) == 0) blocks_.about(i).changed = revision_;
    blocks_.give_values(i, z, bit);
  }
  Page& values = blocks_.page(i);
  if (values.scan[in_block] == scan_) return;
  values.scan[in_block] = scan_;
  float& log_odds = values.log_odds[in_block];
  log_odds = moved(log_odds, hit_, min_, max_);
  if (log_odds < occupied_ || (b.occupied[z] & bit) != 0) return;
  b.occupied[z] |= bit;
  blocks_.about(i).changed = revision_;
  changes_.note(blocks_, i, z, bit, revision_);
}

// Queries

CellState LogOddsMap::state_of(const Cell& cell) const {
  const int i = blocks_.find(block_of(cell)), in_block = index_in_block(cell);
  return i < 0 ? CellState::kUnknown : blocks_.block(i).state(in_block >> 6, in_block & 63);
}

float LogOddsMap::log_odds(const Cell& cell) const {
  const int i = blocks_.find(block_of(cell));
  return i < 0 ? 0.0F : blocks_.log_odds(i, index_in_block(cell));
}

void LogOddsMap::occupied_within(const Vector3& center_local_m, double radius_m, TimeNs since,
                                 std::vector<Vector3>& centers_local_m) const {
  centers_local_m.clear();
  // A cell hit in a scan whose time is not kept counts as hit long ago.
  const auto recent = [&](std::uint32_t scan) {
    if (since == kEver) return true;
    return scan + MapConstants::kScanTimes > scan_ && scan_times_[scan % MapConstants::kScanTimes] >= since;
  };
  const double reach_m = radius_m + edge_m_;
  const auto add_block = [&](const Cell& block, const Bits& occupied) {
    const Page& values = blocks_.page(blocks_.find(block));
    for_cells(occupied, [&](int in_block) {
      const Vector3 cell_local_m = center_of(cell_in(block, in_block));
      if (!overlaps_ball(cell_local_m, center_local_m, radius_m)) return;
      if (recent(values.scan[in_block])) centers_local_m.push_back(cell_local_m);
    });
  };
  for_occupied_blocks(center_local_m.array() - reach_m, center_local_m.array() + reach_m, add_block);
}

const CellBlock::Bits* LogOddsMap::occupied_of(const Cell& at) const {
  if (!changes_.any_in(blocks_.place_of(at))) return nullptr;
  const int i = blocks_.find(at);
  return i < 0 ? nullptr : &blocks_.block(i).occupied;
}

bool LogOddsMap::changed_since(std::uint64_t revision, std::vector<VoxelGrid>& boxes) const {
  boxes.clear();
  if (!removed_.covers(revision)) return false;
  const auto add = [&](const Cell& at) { boxes.push_back({edge_m_, at * kSide, Cell::Constant(kSide)}); };
  for (int i = 0; i < blocks_.size(); ++i) {
    if (blocks_.about(i).used && blocks_.about(i).changed > revision) add(blocks_.about(i).at);
  }
  removed_.for_each_since(revision, add);
  return true;
}

bool LogOddsMap::look_at(const Cell& at, CellBlock& states) const {
  const int i = blocks_.find(at);
  if (i < 0) return false;
  const Block& b = blocks_.block(i);
  states = {at, b.occupied, b.known()};
  for (int z = 0; z < kSide; ++z) states.free[z] &= ~b.occupied[z];
  return true;
}

std::vector<CellBlock> LogOddsMap::blocks_above(double p) const {
  const float least = log_odds_of(p);
  std::vector<CellBlock> blocks;
  for (int i = 0; i < blocks_.size(); ++i) {
    CellBlock states;
    if (!blocks_.about(i).used || !look_at(blocks_.about(i).at, states)) continue;
    for_cells(Bits(states.occupied), [&](int in_block) {
      if (blocks_.page(i).log_odds[in_block] > least) return;
      states.occupied[in_block >> 6] &= ~(std::uint64_t{1} << (in_block & 63));
    });
    blocks.push_back(states);
  }
  return blocks;
}

void LogOddsMap::append_voxels(MapVoxels& copy) const {
  copy.edge_m = edge_m_;
  copy.states = {"free", "occupied"};
  copy.occupied_from = 1;
  copy.log_odds = true;
  // There are millions of cells: reserve once. Blocks that are not used have no known cells.
  std::size_t count = copy.size();
  for (int i = 0; i < blocks_.size(); ++i) {
    for (const std::uint64_t word : blocks_.block(i).known()) count += std::popcount(word);
  }
  copy.centers_local_m.reserve(count);
  copy.state.reserve(count);
  copy.value.reserve(count);
  for (int i = 0; i < blocks_.size(); ++i) {
    const Block& b = blocks_.block(i);
    for_cells(b.known(), [&](int in_block) {
      const Vector3 center_local_m = center_of(cell_in(blocks_.about(i).at, in_block));
      copy.add(center_local_m, has(b.occupied, in_block), blocks_.log_odds(i, in_block));
    });
  }
}

}  // namespace

std::unique_ptr<OccupancyMap> make_occupancy_map(const OccupancyMapConfig& config) {
  return std::make_unique<LogOddsMap>(config);
}

// Settings

void OccupancyMapConfig::visit(ConfigVisitor& v) {
  v.field("edge_m", edge_m, "[m] edge of a cell", Range::between(0.01, 100.0));
  v.field("p_hit", p_hit, "[-] probability that a cell is occupied in which a ray ended", Range{0.5, 1.0, true, true});
  v.field("p_miss", p_miss,
          "[-] probability that a cell is occupied that rays only passed; 0.5: rays clear nothing, the conservative "
          "setting of Kamler 2025",
          Range{0.0, 0.5, true, false});
  v.field("p_occupied", p_occupied, "[-] probability from which a cell counts as occupied",
          Range{0.0, 1.0, true, true});
  v.field("range_max_m", range_max_m,
          "[m] largest length of rays; longer ones clear cells up to this length, without a hit",
          Range{0.0, 1000.0, true});
  v.field("keep_radius_m", keep_radius_m, "[m] distance from the vehicle above which cells are dropped",
          Range{0.0, 1e5, true});
  v.check((p_occupied > p_miss || p_miss == 0.5) && p_occupied < kProbabilityMax, "p_occupied",
          "more than p_miss and less than 0.971");
  v.check(range_max_m <= kMaxRadius_cells * edge_m, "range_max_m", "at most 480 times edge_m");
  v.check(keep_radius_m >= range_max_m, "keep_radius_m", "at least range_max_m");
  v.check(keep_radius_m <= kMaxRadius_cells * edge_m, "keep_radius_m", "at most 480 times edge_m");
}

// Slots per axis for the blocks around a vehicle between two blocks, and for the reach of a scan before blocks are
// dropped.
double OccupancyMapConfig::places_across() const { return 2.0 * keep_radius_m / (CellBlock::kSide * edge_m) + 6.0; }

double OccupancyMapConfig::bytes() const {
  const double blocks = CellBlock::num_in_ball(keep_radius_m / edge_m);
  // Bytes of a block and of a place in the table; shares of blocks with a page of values, and with distances.
  constexpr double kBlock = 400.0, kNearSurfaces = 0.1, kPlace = 12.0, kRequestedShare = 0.25;
  double across = 1.0;  // slots per axis
  while (across < places_across()) across *= 2.0;
  return blocks * (kBlock + kNearSurfaces * sizeof(LogOddsBlocks::Page) + kRequestedShare * DistanceTiles::kTileBytes) +
         across * across * across * kPlace + RayCells::bytes(range_max_m, edge_m);
}

}  // namespace swiftlet
