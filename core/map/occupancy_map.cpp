// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/map/occupancy_map.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/map/cell_walk.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {
namespace {

constexpr std::size_t kScanTimes = 4096;      // number of scans whose times are kept
constexpr std::size_t kTouchedBlocks = 4096;  // touched blocks per scan for which memory is reserved

float log_odds_of(double p) { return static_cast<float>(elementary::log(p / (1.0 - p))); }

/// As OcTree::updateNodeLogOdds.
float moved(float log_odds, float by, float min, float max) {
  log_odds += by;
  return log_odds < min ? min : log_odds > max ? max : log_odds;
}

}  // namespace

OccupancyMap::OccupancyMap(const OccupancyMapConfig& config)
    : config_(config),
      cells_per_m_(1.0 / config.edge_m),
      hit_(log_odds_of(config.p_hit)),
      miss_(log_odds_of(config.p_miss)),
      occupied_(log_odds_of(config.p_occupied)),
      min_(log_odds_of(config.p_min)),
      max_(log_odds_of(config.p_max)),
      rays_(config.edge_m),
      scan_times_(kScanTimes, std::numeric_limits<TimeNs>::min()),
      kept_around_local_m_(Vector3::Constant(std::numeric_limits<double>::infinity())),
      distances_(static_cast<int>(std::ceil(config.distance_max_m / config.edge_m))) {
  for (int n = 1; n <= kMostMisses; ++n) {
    after_misses_[n] = moved(after_misses_[n - 1], miss_, min_, max_);
    if (after_misses_[n] != after_misses_[n - 1]) most_misses_ = n;
  }
  while (1 << bits_ < config.places_across()) ++bits_;
  mask_ = (1 << bits_) - 1;
  places_.assign(std::size_t{1} << 3 * bits_, -1);
  occupied_changes_.assign(places_.size(), {});
  occupied_places_.assign((places_.size() + 63) / 64, 0);
  touched_.reserve(kTouchedBlocks);
}

// Blocks

std::size_t OccupancyMap::place_of(const Cell& block) const {
  return static_cast<std::size_t>((block.x() & mask_) | ((block.y() & mask_) | (block.z() & mask_) << bits_) << bits_);
}

int OccupancyMap::find(const Cell& block) const {
  const int i = places_[place_of(block)];
  return i >= 0 && blocks_[i].at == block ? i : -1;
}

int OccupancyMap::find_or_make(const Cell& block) {
  const std::size_t place = place_of(block);
  int i = places_[place];
  if (i >= 0 && blocks_[i].at == block) return i;
  // A block in the same slot lies beyond the kept radius.
  if (i >= 0) forget(i);
  if (!free_blocks_.empty()) {
    i = free_blocks_.back();
    free_blocks_.pop_back();
  } else {
    i = static_cast<int>(blocks_.size());
    if (blocks_.size() % kChunk == 0) chunks_.push_back(std::make_unique<Block[]>(kChunk));
    blocks_.emplace_back();
  }
  places_[place] = i;
  blocks_[i] = {.at = block, .used = true};
  return i;
}

void OccupancyMap::forget(int i) {
  About& about = blocks_[i];
  removed_.note(revision_, about.at);
  if (about.page != 0) free_pages_.push_back(about.page);
  block(i) = {};
  note_occupied(i);
  occupied_changes_[place_of(about.at)].touched = 0;
  places_[place_of(about.at)] = -1;
  about = {};
  free_blocks_.push_back(i);
}

void OccupancyMap::keep_around(const Vector3& center_local_m) {
  // Blocks are dropped whole: nothing changes until the vehicle has moved by a part of a block.
  const double block_m = kSide * config_.edge_m;
  if ((center_local_m - kept_around_local_m_).norm() < 0.25 * block_m) return;
  kept_around_local_m_ = center_local_m;
  const auto far_away = [&](const Cell& at) {
    const Vector3 middle_local_m = (at.cast<double>().array() + 0.5) * block_m;
    return (middle_local_m - center_local_m).squaredNorm() > config_.keep_radius_m * config_.keep_radius_m;
  };
  bool removes = false;
  for (int i = 0; i < static_cast<int>(blocks_.size()); ++i) {
    if (!blocks_[i].used || !far_away(blocks_[i].at)) continue;
    if (!removes) ++revision_;
    removes = true;
    forget(i);
  }
  if (removes) distances_.forget_if(far_away);
}

void OccupancyMap::note_occupied(int i) {
  const std::size_t place = place_of(blocks_[i].at);
  const Bits& bits = block(i).occupied;
  const bool any = std::any_of(bits.begin(), bits.end(), [](std::uint64_t word) { return word != 0; });
  const std::uint64_t bit = std::uint64_t{1} << (place & 63);
  if (any || (occupied_places_[place >> 6] & bit) != 0)
    occupied_changes_[place].revision = static_cast<std::uint32_t>(revision_);
  occupied_places_[place >> 6] = any ? occupied_places_[place >> 6] | bit : occupied_places_[place >> 6] & ~bit;
}

void OccupancyMap::note_touched(int i, int z, std::uint64_t cells) {
  std::uint32_t& touched = occupied_changes_[place_of(blocks_[i].at)].touched;
  if (touched == 0) {
    touched_.push_back({blocks_[i].at});
    touched = static_cast<std::uint32_t>(touched_.size());
  }
  Touched& entry = touched_[touched - 1];
  entry.cells[z] |= cells;
  entry.occupied[z] = block(i).occupied[z];
}

void OccupancyMap::give_page(int i) {
  if (blocks_[i].page != 0) return;
  if (free_pages_.empty()) {
    pages_.push_back(std::make_unique<Page>());
    free_pages_.push_back(static_cast<std::uint32_t>(pages_.size()));
  }
  blocks_[i].page = free_pages_.back();
  free_pages_.pop_back();
}

// Updates

void OccupancyMap::insert(std::span<const Ray> rays, TimeNs now) {
  for (const Touched& touched : touched_) occupied_changes_[place_of(touched.at)].touched = 0;
  touched_.clear();
  touched_after_ = revision_;
  ++scan_;
  ++revision_;
  scan_times_[scan_ % kScanTimes] = now;
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

void OccupancyMap::miss(int i, const Bits& passed) {
  Block& b = block(i);
  std::uint64_t fresh = 0;
  const bool counted_to_the_end = after_misses_[kMostMisses] == min_;
  for (int z = 0; z < kSide; ++z) {
    const std::uint64_t cells = passed[z];
    if (cells == 0) continue;
    if (const std::uint64_t valued = cells & b.valued[z]; valued != 0) miss_valued(i, z, valued);
    std::uint64_t carry = cells & ~b.valued[z];
    std::uint64_t &ones = b.misses_1[z], &twos = b.misses_2[z], &fours = b.misses_4[z];
    // Cells whose counter is full, or that further misses no longer change.
    const std::uint64_t most = ((most_misses_ & 1) != 0 ? ones : ~ones) & ((most_misses_ & 2) != 0 ? twos : ~twos) &
                               ((most_misses_ & 4) != 0 ? fours : ~fours) & carry;
    if (most != 0 && !counted_to_the_end) {
      give_values(i, z, most);
      miss_valued(i, z, most);
    }
    carry &= ~most;
    fresh |= carry & ~(ones | twos | fours);
    const std::uint64_t carry_2 = carry & ones, carry_4 = carry_2 & twos;
    ones ^= carry;
    twos ^= carry_2;
    fours ^= carry_4;
  }
  if (fresh != 0) blocks_[i].changed = revision_;
}

void OccupancyMap::miss_valued(int i, int z, std::uint64_t cells) {
  Page& values = page(blocks_[i].page);
  std::uint64_t& occupied = block(i).occupied[z];
  const std::uint64_t before = occupied;
  for (std::uint64_t left = cells; left != 0; left &= left - 1) {
    const int bit = std::countr_zero(left);
    float& log_odds = values.log_odds[z << 6 | bit];
    log_odds = moved(log_odds, miss_, min_, max_);
    if (log_odds < occupied_) occupied &= ~(std::uint64_t{1} << bit);
  }
  if (occupied == before) return;
  blocks_[i].changed = revision_;
  note_touched(i, z, occupied ^ before);
  note_occupied(i);
}

int OccupancyMap::misses_of(const Block& b, int z, int bit) const {
  const auto digit = [&](const Bits& bits) { return static_cast<int>(bits[z] >> bit & 1U); };
  return digit(b.misses_1) + 2 * digit(b.misses_2) + 4 * digit(b.misses_4);
}

// Gives counted cells a log-odds value of their own.
void OccupancyMap::give_values(int i, int z, std::uint64_t cells) {
  give_page(i);
  Block& b = block(i);
  Page& values = page(blocks_[i].page);
  for (std::uint64_t left = cells; left != 0; left &= left - 1) {
    const int bit = std::countr_zero(left);
    values.log_odds[z << 6 | bit] = after_misses_[misses_of(b, z, bit)];
    values.scan[z << 6 | bit] = 0;
  }
  b.valued[z] |= cells;
  b.misses_1[z] &= ~cells;
  b.misses_2[z] &= ~cells;
  b.misses_4[z] &= ~cells;
}

void OccupancyMap::hit(const Cell& cell) {
  const int i = find_or_make(block_of(cell)), in_block = index_in_block(cell), z = in_block >> 6;
  const std::uint64_t bit = std::uint64_t{1} << (in_block & 63);
  Block& b = block(i);
  if ((b.valued[z] & bit) == 0) {
    if (misses_of(b, z, in_block & 63) == 0) blocks_[i].changed = revision_;
    give_values(i, z, bit);
  }
  Page& values = page(blocks_[i].page);
  if (values.scan[in_block] == scan_) return;
  values.scan[in_block] = scan_;
  float& log_odds = values.log_odds[in_block];
  log_odds = moved(log_odds, hit_, min_, max_);
  if (log_odds < occupied_ || (b.occupied[z] & bit) != 0) return;
  b.occupied[z] |= bit;
  blocks_[i].changed = revision_;
  note_touched(i, z, bit);
  note_occupied(i);
}

// Queries

CellState OccupancyMap::state(const Vector3& p_local_m) const { return state_of(cell_of(p_local_m)); }

CellState OccupancyMap::state_of(const Cell& cell) const {
  const int i = find(block_of(cell));
  if (i < 0) return CellState::kUnknown;
  const Block& b = block(i);
  const int in_block = index_in_block(cell), z = in_block >> 6;
  const auto has = [&](const Bits& bits) { return (bits[z] >> (in_block & 63) & 1U) != 0; };
  if (has(b.occupied)) return CellState::kOccupied;
  return has(b.valued) || has(b.misses_1) || has(b.misses_2) || has(b.misses_4) ? CellState::kFree
                                                                                : CellState::kUnknown;
}

bool OccupancyMap::known(const Cell& cell) const { return state_of(cell) != CellState::kUnknown; }

float OccupancyMap::log_odds(const Cell& cell) const {
  const int i = find(block_of(cell));
  if (i < 0) return 0.0F;
  const int in_block = index_in_block(cell), z = in_block >> 6, bit = in_block & 63;
  const Block& b = block(i);
  return (b.valued[z] >> bit & 1U) != 0 ? page(blocks_[i].page).log_odds[in_block]
                                        : after_misses_[misses_of(b, z, bit)];
}

template <class Fn>
void OccupancyMap::for_occupied(const Vector3& min_local_m, const Vector3& max_local_m, Fn&& fn) const {
  const Cell low = block_of(cell_of(min_local_m)), high = block_of(cell_of(max_local_m));
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) {
        const int i = find({x, y, z});
        if (i < 0 || blocks_[i].page == 0) continue;
        const Block& b = block(i);
        for (int layer = 0; layer < kSide; ++layer) {
          for (std::uint64_t left = b.occupied[layer]; left != 0; left &= left - 1) {
            const int bit = std::countr_zero(left);
            fn(i, layer << 6 | bit, center_of({x * kSide + (bit & 7), y * kSide + (bit >> 3), z * kSide + layer}));
          }
        }
      }
    }
  }
}

void OccupancyMap::occupied_within(const Vector3& center_local_m, double radius_m, TimeNs since,
                                   std::vector<Vector3>& centers_local_m) const {
  centers_local_m.clear();
  const double reach_m = radius_m + config_.edge_m, half_m = 0.5 * config_.edge_m;
  // A cell hit in a scan whose time is not kept counts as hit long ago.
  const auto recent = [&](std::uint32_t scan) {
    if (since == kEver) return true;
    return scan + kScanTimes > scan_ && scan_times_[scan % kScanTimes] >= since;
  };
  for_occupied(center_local_m.array() - reach_m, center_local_m.array() + reach_m,
               [&](int i, int in_block, const Vector3& cell_local_m) {
                 const Vector3 gap = ((cell_local_m - center_local_m).array().abs() - half_m).cwiseMax(0.0);
                 if (gap.squaredNorm() > radius_m * radius_m) return;
                 if (recent(page(blocks_[i].page).scan[in_block])) centers_local_m.push_back(cell_local_m);
               });
}

void OccupancyMap::occupied_in(const Vector3& min_local_m, const Vector3& max_local_m,
                               std::vector<Vector3>& centers_local_m) const {
  centers_local_m.clear();
  const double half_m = 0.5 * config_.edge_m;
  for_occupied(min_local_m, max_local_m, [&](int, int, const Vector3& cell_local_m) {
    const bool above = (cell_local_m.array() + half_m >= min_local_m.array()).all();
    if (above && (cell_local_m.array() - half_m <= max_local_m.array()).all()) centers_local_m.push_back(cell_local_m);
  });
}

double OccupancyMap::distance_m(const Vector3& p_local_m, double max_m) const {
  double least_sq = max_m * max_m;
  const double half_m = 0.5 * config_.edge_m;
  for_occupied(p_local_m.array() - max_m, p_local_m.array() + max_m, [&](int, int, const Vector3& cell_local_m) {
    const Vector3 gap = ((cell_local_m - p_local_m).array().abs() - half_m).cwiseMax(0.0);
    least_sq = std::min(least_sq, gap.squaredNorm());
  });
  return std::sqrt(least_sq);
}

double OccupancyMap::clearance_m(const Vector3& p_local_m, double max_m) const {
  const std::int16_t squared = distances_.squared(cell_of(p_local_m), *this, revision_);
  if (squared != DistanceTiles::kFar) return std::min(max_m, std::sqrt(static_cast<double>(squared)) * config_.edge_m);
  return max_m <= config_.distance_max_m ? max_m : OccupancyView::clearance_m(p_local_m, max_m);
}

const RayCells::Bits* OccupancyMap::occupied_of(const Cell& at) const {
  const std::size_t place = place_of(at);
  if ((occupied_places_[place >> 6] >> (place & 63) & 1U) == 0) return nullptr;
  const int i = find(at);
  return i < 0 ? nullptr : &block(i).occupied;
}

// Blocks of the same slot share a change counter; a change far away only causes an unnecessary check.
void OccupancyMap::append_changes(const Cell& low, const Cell& high, std::uint64_t since,
                                  std::vector<Change>& changes) const {
  const bool remembered = since >= touched_after_;
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      const OccupiedChange* const row = occupied_changes_.data() + place_of({0, y, z});
      for (int x = low.x(); x <= high.x(); ++x) {
        const OccupiedChange& change = row[x & mask_];
        if (change.revision <= since) continue;
        const Cell block(x, y, z);
        const bool known = remembered && change.touched != 0 && touched_[change.touched - 1].at == block;
        const Touched* touched = known ? &touched_[change.touched - 1] : nullptr;
        changes.push_back({block, known ? &touched->cells : nullptr, known ? &touched->occupied : nullptr});
      }
    }
  }
}

std::optional<SegmentHit> OccupancyMap::first_hit(const Vector3& from_local_m, const Vector3& to_local_m) const {
  Cell cell;
  const double hit_distance_m = distance_to_first_m(from_local_m, to_local_m, cells_per_m_, cell, [&](const Cell& at) {
    return state_of(at) == CellState::kOccupied;
  });
  if (hit_distance_m < 0.0) return std::nullopt;
  return SegmentHit{hit_distance_m, center_of(cell)};
}

bool OccupancyMap::changed_since(std::uint64_t revision, std::vector<VoxelGrid>& boxes) const {
  boxes.clear();
  if (!removed_.covers(revision)) return false;
  const auto add = [&](const Cell& at) { boxes.push_back({config_.edge_m, at * kSide, Cell::Constant(kSide)}); };
  for (const About& about : blocks_) {
    if (about.used && about.changed > revision) add(about.at);
  }
  removed_.for_each_since(revision, add);
  return true;
}

bool OccupancyMap::look_at(const Cell& at, CellBlock& states) const {
  const int i = find(at);
  if (i < 0) return false;
  const Block& b = block(i);
  states.at = at;
  states.occupied = b.occupied;
  for (int z = 0; z < kSide; ++z) {
    states.free[z] = (b.valued[z] | b.misses_1[z] | b.misses_2[z] | b.misses_4[z]) & ~b.occupied[z];
  }
  return true;
}

std::vector<CellBlock> OccupancyMap::blocks_above(double p) const {
  const float least = log_odds_of(p);
  std::vector<CellBlock> blocks;
  for (const About& about : blocks_) {
    CellBlock states;
    if (!about.used || !look_at(about.at, states)) continue;
    for (int z = 0; z < kSide; ++z) {
      for (std::uint64_t left = states.occupied[z]; left != 0; left &= left - 1) {
        const int bit = std::countr_zero(left);
        if (!(page(about.page).log_odds[z << 6 | bit] > least)) states.occupied[z] &= ~(std::uint64_t{1} << bit);
      }
    }
    blocks.push_back(states);
  }
  return blocks;
}

void OccupancyMap::append_voxels(MapVoxels& copy) const {
  copy.edge_m = config_.edge_m;
  copy.states = {"free", "occupied"};
  copy.occupied_from = 1;
  copy.log_odds = true;
  const auto known = [](const Block& b, int z) {
    return b.occupied[z] | b.valued[z] | b.misses_1[z] | b.misses_2[z] | b.misses_4[z];
  };
  // There are millions of cells: reserve once.
  std::size_t count = copy.size();
  for (int i = 0; i < static_cast<int>(blocks_.size()); ++i) {
    for (int z = 0; blocks_[i].used && z < kSide; ++z) count += std::popcount(known(block(i), z));
  }
  copy.centers_local_m.reserve(count);
  copy.state.reserve(count);
  copy.value.reserve(count);
  for (int i = 0; i < static_cast<int>(blocks_.size()); ++i) {
    const About& about = blocks_[i];
    if (!about.used) continue;
    const Block& b = block(i);
    for (int z = 0; z < kSide; ++z) {
      for (auto bits = known(b, z); bits != 0; bits &= bits - 1) {
        const int bit = std::countr_zero(bits);
        const Cell cell = kSide * about.at + Cell(bit & 7, bit >> 3, z);
        const bool valued = (b.valued[z] >> bit & 1U) != 0, occupied = (b.occupied[z] >> bit & 1U) != 0;
        copy.add(center_of(cell), occupied,
                 valued ? page(about.page).log_odds[z << 6 | bit] : after_misses_[misses_of(b, z, bit)]);
      }
    }
  }
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
  v.field("p_min", p_min, "[-] lower limit of a cell's probability", Range{0.0, 0.5, true, true});
  v.field("p_max", p_max, "[-] upper limit of a cell's probability", Range{0.5, 1.0, true, true});
  v.field("range_max_m", range_max_m, "[m] length up to which rays hit and clear", Range{0.0, 1000.0, true});
  v.field("keep_radius_m", keep_radius_m, "[m] cells farther from the vehicle are dropped", Range{0.0, 1e5, true});
  v.field("distance_max_m", distance_max_m,
          "[m] largest distance to the nearest occupied cell that is cached; larger ones are searched",
          Range{0.0, 1000.0, true});
  v.check((p_occupied > p_miss || p_miss == 0.5) && p_occupied < p_max, "p_occupied",
          "more than p_miss and less than p_max");
  v.check(range_max_m <= 480.0 * edge_m, "range_max_m", "at most 480 times edge_m");
  v.check(keep_radius_m >= range_max_m, "keep_radius_m", "at least range_max_m");
  v.check(keep_radius_m <= 480.0 * edge_m, "keep_radius_m", "at most 480 times edge_m");
  v.check(distance_max_m <= DistanceTiles::kMostReach * edge_m, "distance_max_m", "at most 64 times edge_m");
}

// Slots per axis for the blocks around a vehicle between two blocks, and for the reach of a scan before blocks are
// dropped.
double OccupancyMapConfig::places_across() const { return 2.0 * keep_radius_m / (RayCells::kSide * edge_m) + 6.0; }

double OccupancyMapConfig::bytes() const {
  const double radius_cells = keep_radius_m / edge_m;
  const double blocks = 4.19 * radius_cells * radius_cells * radius_cells / 512.0;
  constexpr double kBlock = 400.0, kPage = 4096.0, kNearSurfaces = 0.1, kPlace = 12.0, kTile = 1100.0,
                   kRequestedShare = 0.25;
  double across = 1.0;  // slots per axis
  while (across < places_across()) across *= 2.0;
  return blocks * (kBlock + kNearSurfaces * kPage + kRequestedShare * kTile) + across * across * across * kPlace +
         RayCells::bytes(range_max_m, edge_m);
}

}  // namespace swiftlet
