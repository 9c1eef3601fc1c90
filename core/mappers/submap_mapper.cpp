// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/mappers/submap_mapper.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "core/mappers/near_cells.hpp"
#include "core/mappers/scan_rays.hpp"
#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/core/base/rounding.hpp"

namespace swiftlet {
namespace {

// [m] Distance from its start after which a submap continues in another piece. Larger pieces take more memory
// while they grow.
constexpr double kPiece_m = 12.0;
constexpr double kPathMargin_m = 2.0;  // margin for the offset of the LiDARs and the flight between two scans
constexpr int kLookEvery = 32;         // stride of the blocks sampled to estimate how much of a piece is covered
constexpr int kNewest = 2;             // newest pieces, which are never thinned
// [-] Largest number of pieces of one submap; more are merged into one. Larger values keep more votes on cells that
// changed, and take more memory.
constexpr std::size_t kMaxOfSubmap = 4;
// [m] Largest distance to the nearest occupied cell that is cached; larger distances are searched on request. Larger
// values take more memory around changed cells.
constexpr double kDistanceMax_m = 2.0;
// Submap of a piece from before the first submap.
constexpr int kNoSubmap = -1;

class SubmapMapper : public Mapper {
 public:
  explicit SubmapMapper(const SubmapMapperConfig& config)
      : config_(config),
        scan_rays_({config.every_column, config.range_min_m, config.range_max_m, config.clear_range_m}),
        vehicles_(config.tracked_radius_m),
        map_(make_submap_map(config.whole())) {}

  void step(const MapperInput& input, Outbox&) override {
    ENSURE(input.submaps != nullptr, input.observation.t);
    p_local_m_ = input.estimate.T_local_body.translation();
    if (input.submaps->revision != seen_) follow(*input.submaps);
    vehicles_.update(input);
    for (const auto& cloud : input.clouds) take(*cloud);
  }

  const OccupancyView& map() const override { return *map_; }
  bool needs_submaps() const override { return true; }

  void append_pieces(std::vector<MapPiece>& pieces) const override {
    for (const Kept& kept : pieces_) {
      if (!kept.given && kept.piece.submap != kNoSubmap) pieces.push_back(kept.piece);
    }
    if (growing_ == nullptr || growing_submap_ == kNoSubmap) return;
    MapPiece piece = finished();
    if (!piece.cells->empty()) pieces.push_back(std::move(piece));
  }

  void append_counters(std::vector<Counter>& counters) const override {
    scan_rays_.append_counters(counters);
    counters.push_back({"pieces of the map that were dropped", num_forgotten_, num_finished_, "pieces_max"});
  }

  void append_overlays(std::vector<Overlay>& overlays) const override {
    overlays.push_back(near_cells(*map_, p_local_m_));
    Overlay all;
    all.name = "mapping.map";
    all.kind = Overlay::Kind::kCubes;
    all.size_m = static_cast<float>(config_.edge_m);
    std::vector<Vector3> centers_local_m;
    map_->append_occupied(centers_local_m);
    double low_m = std::numeric_limits<double>::infinity(), high_m = -low_m;
    for (const Vector3& center_local_m : centers_local_m) {
      low_m = std::min(low_m, center_local_m.z());
      high_m = std::max(high_m, center_local_m.z());
    }
    const auto color_of_height = [](float f) {
      return Eigen::Vector4f(0.15F + 0.75F * f, 0.35F + 0.35F * f, 0.60F - 0.45F * f, 1.0F);
    };
    for (const Vector3& center_local_m : centers_local_m) {
      all.positions.push_back(center_local_m.cast<float>());
      all.colors.push_back(
          color_of_height(static_cast<float>((center_local_m.z() - low_m) / std::max(high_m - low_m, config_.edge_m))));
    }
    if (!all.positions.empty()) {
      all.legend = {{"lowest occupied cells of all submaps", color_of_height(0.0F)},
                    {"highest occupied cells of all submaps", color_of_height(1.0F)}};
    }
    overlays.push_back(std::move(all));
  }

 private:
  struct Kept {
    MapPiece piece;
    bool given = false;
    int in_map = 0;
  };

  /// Follows the pose graph: moves pieces, finishes the growing one when a submap began, takes pieces of a loaded map.
  void follow(const SubmapPoses& poses) {
    seen_ = poses.revision;
    if (!poses.T_local_own.empty()) attach(poses.T_local_own.front());
    if (poses.dropped.count != num_dropped_) hang_elsewhere(poses.dropped);
    const int newest = static_cast<int>(poses.T_local_own.size()) - 1;
    // The growing submap stands still. If an estimator moves it, the present piece is finished.
    const auto stands = [&] {
      const Pose T = poses.T_local_own[static_cast<std::size_t>(growing_submap_)] * T_submap_growing_;
      return (T.matrix() - T_local_growing().matrix()).cwiseAbs().maxCoeff() < kRounding;
    };
    if (growing_ != nullptr && growing_submap_ != kNoSubmap && (growing_submap_ != newest || !stands())) finish();
    newest_submap_ = newest;
    if (newest >= 0) T_local_newest_ = poses.T_local_own.back();
    for (const Kept& kept : pieces_) {
      const auto& its = kept.given ? poses.T_local_given : poses.T_local_own;
      if (kept.piece.submap == kNoSubmap) continue;
      map_->move(kept.in_map, its[static_cast<std::size_t>(kept.piece.submap)] * kept.piece.T_submap_cells);
    }
    if (given_taken_ || poses.given.empty()) return;
    given_taken_ = true;
    for (const MapPiece& piece : poses.given) {
      const Pose& T_local_submap = poses.T_local_given[static_cast<std::size_t>(piece.submap)];
      keep(piece, true, T_local_submap * piece.T_submap_cells, kGivenAge, kEver);
    }
  }

  /// Attaches pieces from before the first submap to it.
  void attach(const Pose& T_local_first) {
    if (growing_ != nullptr && growing_submap_ == kNoSubmap) {
      growing_submap_ = 0;
      T_submap_growing_ = T_local_first.inverse() * T_local_growing();
    }
    for (Kept& kept : pieces_) {
      if (kept.piece.submap != kNoSubmap) continue;
      kept.piece.submap = 0;
      // T_submap_cells held T_local_cells until now
      kept.piece.T_submap_cells = T_local_first.inverse() * kept.piece.T_submap_cells;
    }
  }

  /// Attaches the pieces of a dropped submap to an older one. If several were dropped since the last step, their poses
  /// are unknown and their pieces are discarded.
  void hang_elsewhere(const SubmapPoses::Dropped& dropped) {
    const bool known = dropped.count == num_dropped_ + 1;
    num_dropped_ = dropped.count;
    if (newest_submap_ == kNoSubmap || (known && dropped.submap != newest_submap_)) return;
    if (growing_ != nullptr && growing_submap_ == newest_submap_) {
      growing_submap_ = dropped.into;
      T_submap_growing_ = dropped.T_into_submap * T_submap_growing_;
      if (!known) forget_growing();
    }
    std::erase_if(pieces_, [&](Kept& kept) {
      if (kept.given || kept.piece.submap != newest_submap_) return false;
      kept.piece.submap = dropped.into;
      kept.piece.T_submap_cells = dropped.T_into_submap * kept.piece.T_submap_cells;
      if (!known) map_->remove(kept.in_map);
      return !known;
    });
  }

  void take(const LocalCloud& cloud) {
    const double edge_m = CellBlock::kSide * config_.edge_m;
    if (growing_ != nullptr && (p_local_m_ - edge_m * offset_.cast<double>()).norm() > kPiece_m) finish();
    if (growing_ == nullptr) begin();
    std::vector<OccupancyMap::Ray>& rays = scan_rays_.take(cloud, vehicles_);
    const Eigen::Vector3f offset_m = (edge_m * offset_.cast<double>()).cast<float>();
    for (OccupancyMap::Ray& ray : rays) {
      ray.origin_local_m -= offset_m;
      ray.end_local_m -= offset_m;
    }
    growing_->insert(rays, cloud.end());
    grown_until_ = cloud.end();
    map_->set_growing(growing_.get(), offset_);
  }

  /// Begins a piece whose blocks coincide with those of the map, so that they need no resampling until the graph moves
  /// it.
  void begin() {
    growing_ = make_occupancy_map(config_.growing());
    offset_ = (p_local_m_ / (CellBlock::kSide * config_.edge_m)).array().round().cast<int>();
    growing_submap_ = newest_submap_;
    T_submap_growing_ = newest_submap_ == kNoSubmap ? T_local_growing() : T_local_newest_.inverse() * T_local_growing();
  }

  Pose T_local_growing() const {
    Pose T = Pose::Identity();
    T.translation() = CellBlock::kSide * config_.edge_m * offset_.cast<double>();
    return T;
  }

  /// The growing piece in its finished form.
  MapPiece finished() const {
    return {growing_submap_, T_submap_growing_,
            std::make_shared<const SubmapCells>(config_.edge_m, growing_->blocks_above(config_.p_occupied))};
  }

  void finish() {
    MapPiece piece = finished();
    forget_growing();
    ++num_finished_;
    if (piece.cells->empty()) return;
    const int submap = piece.submap;
    keep(std::move(piece), false, T_local_growing(), kOwnAge, grown_until_);
    merge_pieces(submap);
    thin_out();
  }

  void forget_growing() {
    map_->set_growing(nullptr, Cell::Zero());
    growing_.reset();
  }

  void keep(MapPiece piece, bool given, const Pose& T_local_cells, int age, TimeNs seen) {
    const int in_map = map_->add(piece.cells, T_local_cells, age, seen);
    const auto own = std::find_if(pieces_.begin(), pieces_.end(), [](const Kept& kept) { return !kept.given; });
    pieces_.insert(given ? own : pieces_.end(), {std::move(piece), given, in_map});
    if (static_cast<int>(pieces_.size()) <= config_.pieces_max) return;
    map_->remove(pieces_.front().in_map);
    pieces_.erase(pieces_.begin());
    ++num_forgotten_;
  }

  /// Merges more than kMaxOfSubmap pieces of one submap into one, in the frame of the oldest.
  void merge_pieces(int submap) {
    const auto hangs_on_it = [submap](const Kept& kept) {
      return !kept.given && submap != kNoSubmap && kept.piece.submap == submap;
    };
    const auto num = static_cast<std::size_t>(std::count_if(pieces_.begin(), pieces_.end(), hangs_on_it));
    if (num <= kMaxOfSubmap) return;
    const Kept oldest = *std::find_if(pieces_.begin(), pieces_.end(), hangs_on_it);
    const std::unique_ptr<SubmapMap> alone = make_submap_map(config_.whole());
    for (const Kept& kept : pieces_) {
      if (!hangs_on_it(kept)) continue;
      alone->add(kept.piece.cells, oldest.piece.T_submap_cells.inverse() * kept.piece.T_submap_cells, kOwnAge, 0);
    }
    std::vector<CellBlock> blocks;
    alone->append_blocks(blocks);
    const Pose T_local_cells = map_->T_local_cells(oldest.in_map);
    for (CellBlock& block : blocks) clear_outvoted(T_local_cells, block);
    std::erase_if(pieces_, [&](const Kept& kept) {
      if (!hangs_on_it(kept)) return false;
      map_->remove(kept.in_map);
      return true;
    });
    keep({submap, oldest.piece.T_submap_cells, std::make_shared<const SubmapCells>(config_.edge_m, blocks)}, false,
         T_local_cells, kOwnAge, grown_until_);
  }

  /// Removes cells that other pieces outvoted. In a merged piece they would count as the newest.
  void clear_outvoted(const Pose& T_local_cells, CellBlock& block) const {
    for (int z = 0; z < CellBlock::kSide; ++z) {
      const auto word = static_cast<std::size_t>(z);
      for (std::uint64_t left = block.occupied[word] | block.free[word]; left != 0; left &= left - 1) {
        const int bit = std::countr_zero(left);
        const Vector3 cell = (CellBlock::kSide * block.at + Cell(bit & 7, bit >> 3, z)).cast<double>();
        const CellState state = map_->state(T_local_cells * (config_.edge_m * (cell.array() + 0.5)).matrix());
        const std::uint64_t others = ~(std::uint64_t{1} << bit);
        if (state != CellState::kOccupied) block.occupied[word] &= others;
        if (state != CellState::kFree) block.free[word] &= others;
      }
    }
  }

  /// Reduces older pieces to the cells that newer ones lack.
  void thin_out() {
    if (config_.covered_share >= 1.0) return;
    const auto num = static_cast<int>(pieces_.size()) - kNewest;
    for (int i = 0; i < num; ++i) {
      Kept& kept = pieces_[static_cast<std::size_t>(i)];
      if (map_->share_known_by_newer(kept.in_map, kLookEvery) < config_.covered_share) continue;
      kept.piece.cells = map_->needed_of(kept.in_map);
      map_->replace(kept.in_map, kept.piece.cells);
    }
    std::erase_if(pieces_, [this](const Kept& kept) {
      if (!kept.piece.cells->empty()) return false;
      map_->remove(kept.in_map);
      return true;
    });
  }

  /// [-] Ages of the pieces of a loaded map and of own ones: own pieces are newer.
  static constexpr int kGivenAge = 0, kOwnAge = 1;

  SubmapMapperConfig config_;
  ScanRays scan_rays_;
  VehiclesAround vehicles_;
  std::unique_ptr<SubmapMap> map_;
  Vector3 p_local_m_ = Vector3::Zero();
  std::uint64_t seen_ = 0;         // revision of the poses at the last step
  std::uint64_t num_dropped_ = 0;  // dropped submaps at the last step
  int newest_submap_ = kNoSubmap;
  Pose T_local_newest_ = Pose::Identity();
  bool given_taken_ = false;
  std::vector<Kept> pieces_;  // the oldest first
  std::uint64_t num_finished_ = 0, num_forgotten_ = 0;
  // The growing piece. It is aligned with whole blocks of the local frame.
  std::unique_ptr<OccupancyMap> growing_;  // null: begins with the next scan
  Cell offset_ = Cell::Zero();
  int growing_submap_ = kNoSubmap;
  Pose T_submap_growing_ = Pose::Identity();
  TimeNs grown_until_ = 0;
};

}  // namespace

void SubmapMapperConfig::visit(ConfigVisitor& v) {
  v.field("every_column", every_column, "[-] every n-th column of a scan is used", Range::between(1, 10000));
  v.field("range_min_m", range_min_m, "[m] range below which returns are of the own vehicle and ignored",
          Range::non_negative());
  v.field("range_max_m", range_max_m,
          "[m] largest length of rays; longer ones clear cells up to this length, without a hit",
          Range{0.0, 1000.0, true});
  v.field("clear_range_m", clear_range_m,
          "[m] length up to which beams without return clear cells; 0: such beams are ignored",
          Range::between(0.0, 1000.0));
  v.field("tracked_radius_m", tracked_radius_m,
          "[m] distance from another vehicle below which returns are ignored, extended by the uncertainty of its "
          "position; 0: "
          "none",
          Range::non_negative());
  v.field("edge_m", edge_m, "[m] edge of a cell", Range::between(0.01, 100.0));
  v.field("p_miss", p_miss, "[-] probability that a cell is occupied that rays only passed",
          Range{0.0, 0.5, true, true});
  v.field("p_occupied", p_occupied,
          "[-] probability above which cells of a finished submap are occupied; from 0.5 up to it they are left out",
          Range{0.5, 1.0, false, true});
  v.field("outvoted_by", outvoted_by,
          "[-] newer pieces in a row that must report a cell free before it is no longer occupied; 0: it always stays "
          "occupied",
          Range::between(0, 3));
  v.field("covered_share", covered_share,
          "[-] share of the cells of a piece known in newer pieces above which those cells are dropped; 1: none are",
          Range::probability());
  v.field("pieces_max", pieces_max, "[-] largest number of pieces; a further one replaces the oldest",
          Range::between(2, 1'000'000));
  v.check(p_occupied < OccupancyMapConfig::kProbabilityMax, "p_occupied", "less than 0.971");
  v.check(clear_range_m <= range_max_m, "clear_range_m", "at most range_max_m");
  v.check(range_max_m + kPiece_m + kPathMargin_m <= OccupancyMapConfig::kMaxRadius_cells * edge_m, "range_max_m",
          "with 14 m more at most 480 times edge_m");
}

SubmapMapConfig SubmapMapperConfig::whole() const {
  return {edge_m, outvoted_by, std::min(kDistanceMax_m, OccupancyMapConfig::kMaxDistance_cells * edge_m)};
}

OccupancyMapConfig SubmapMapperConfig::growing() const {
  OccupancyMapConfig config;
  config.edge_m = edge_m;
  config.p_miss = p_miss;
  config.range_max_m = range_max_m;
  config.keep_radius_m = range_max_m + kPiece_m + kPathMargin_m;
  config.distance_max_m = edge_m;  // distances are not queried
  return config;
}

double SubmapMapperConfig::bytes() const {
  const double blocks = CellBlock::num_in_ball((range_max_m + 0.5 * kPiece_m) / edge_m);
  // Observed share of the reach of a piece; bytes of a block of a piece, and of a block of the composed map.
  constexpr double kSeen = 0.25, kPieceBlock = 110.0, kMapBlock = 200.0;
  return growing().bytes() + pieces_max * kSeen * blocks * (kPieceBlock + kMapBlock);
}

std::unique_ptr<Mapper> make_submap_mapper(const ModuleConfig& config, const AgentSetup&) {
  return std::make_unique<SubmapMapper>(dynamic_cast<const SubmapMapperConfig&>(config));
}

}  // namespace swiftlet
