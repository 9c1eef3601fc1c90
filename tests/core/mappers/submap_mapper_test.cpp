// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/mappers/submap_mapper.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/core/mappers/mapper_driver.hpp"

namespace swiftlet {
namespace {

/// Beams in all directions from a vehicle in a room whose walls are 6.1 m from its middle;
/// open above.
struct Room {
  static constexpr double kWall_m = 6.1;
  static std::shared_ptr<const BeamTable> beams() {
    static const auto table = [] {
      auto made = std::make_shared<BeamTable>();
      made->rows = 21;
      made->cols = 720;
      for (int row = 0; row < made->rows; ++row) {
        for (int column = 0; column < made->cols; ++column) {
          const double a = 2.0 * M_PI * column / made->cols, e = 0.03 * (row - 10);
          made->directions_lidar.push_back(
              Vector3(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)).cast<float>());
        }
      }
      made->origins_lidar.assign(made->directions_lidar.size(), Eigen::Vector3f::Zero());
      made->column_offset_s.assign(static_cast<std::size_t>(made->cols), 0.0F);
      return std::shared_ptr<const BeamTable>(made);
    }();
    return table;
  }
  static std::shared_ptr<const Scan> seen_from(const Pose& T_room_body) {
    auto scan = std::make_shared<Scan>();
    scan->beams = beams();
    for (const Eigen::Vector3f& direction : scan->beams->directions_lidar) {
      const Vector3 d = T_room_body.linear() * direction.cast<double>(), p = T_room_body.translation();
      double range_m = 100.0;
      for (int axis = 0; axis < 2; ++axis) {
        if (d[axis] != 0.0) range_m = std::min(range_m, ((d[axis] > 0.0 ? kWall_m : -kWall_m) - p[axis]) / d[axis]);
      }
      scan->range_m.push_back(static_cast<float>(range_m));
    }
    return scan;
  }
};

/// A mapper of a vehicle in the room; its local frame drifts.
struct SubmapMapping : testing::MapperDriver {
  explicit SubmapMapping(const SubmapMapperConfig& config = {}) : MapperDriver(module_with(config)) {}
  static Module module_with(const SubmapMapperConfig& config) {
    Module module(mapper_module_types(), "submaps");
    module.as<SubmapMapperConfig>() = config;
    return module;
  }
  void begin_submap(const Pose& T_local_submap) {
    submaps.T_local_own.push_back(T_local_submap);
    ++submaps.revision;
  }
  /// Scans from a place of the room.
  void see(const Vector3& p_room_m, int times = 1, const std::vector<Track>& tracks = {}) {
    const Pose T_room_body = make_pose(p_room_m, Eigen::Quaterniond::Identity());
    estimate.T_local_body = T_local_room * T_room_body;
    for (int i = 0; i < times; ++i) MapperDriver::see(Room::seen_from(T_room_body), tracks);
  }
  /// The pose graph moves a submap.
  void move_submap(std::size_t i, const Pose& T_local_submap) {
    submaps.T_local_own[i] = T_local_submap;
    ++submaps.revision;
    see_nothing();
  }
  std::vector<MapPiece> pieces() const {
    std::vector<MapPiece> all;
    mapper->append_pieces(all);
    return all;
  }

  Pose T_local_room = Pose::Identity();
};

Pose at(double x_m, double y_m, double z_m) { return make_pose({x_m, y_m, z_m}, Eigen::Quaterniond::Identity()); }

SubmapMapperConfig every_beam() {
  SubmapMapperConfig config;
  config.every_column = 1;
  return config;
}

TEST(SubmapMapper, MapsSurroundingsBeforeFirstFinishedSubmap) {
  SubmapMapping mapping(every_beam());
  mapping.see({0, 0, 1});
  EXPECT_EQ(mapping.state({3, 1, 1}), CellState::kFree) << "also before there is a submap at all";
  EXPECT_EQ(mapping.state({6.05, 1, 1}), CellState::kOccupied);
  EXPECT_EQ(mapping.state({8, 1, 1}), CellState::kUnknown);
  mapping.begin_submap(at(0, 0, 1));
  mapping.see({0.5, 0, 1});
  EXPECT_EQ(mapping.state({6.05, 1, 1}), CellState::kOccupied);
  EXPECT_EQ(mapping.mapper->map().edge_m(), 0.2);
}

// The wall is in the middle of a cell; the released code of [Orsulic 2021] would have it half a cell off.
TEST(SubmapMapper, FinishedSubmapOccupiesItsPointsCells) {
  SubmapMapping mapping(every_beam());
  mapping.begin_submap(at(0.37, -0.2, 1));
  for (int i = 0; i < 5; ++i) mapping.see({0.03 + 0.3 * i, 0.02, 1.01});
  mapping.begin_submap(at(1.5, 0, 1));
  mapping.see_nothing();
  std::vector<Vector3> occupied_m;
  mapping.mapper->map().occupied_in({-8, -8, 0.5}, {8, 8, 1.5}, occupied_m);
  EXPECT_GT(occupied_m.size(), 500U);
  for (const Vector3& p_m : occupied_m) {
    const double off_m = std::min(std::abs(std::abs(p_m.x()) - 6.1), std::abs(std::abs(p_m.y()) - 6.1));
    EXPECT_NEAR(off_m, 0.0, 1e-9);
  }
}

TEST(SubmapMapper, SingleHitCountsWhileSubmapGrows) {
  SubmapMapping mapping(every_beam());
  mapping.begin_submap(at(0, 0, 1));
  mapping.see({0, 0, 1});
  EXPECT_EQ(mapping.state({6.05, 1, 1}), CellState::kOccupied);
  mapping.begin_submap(at(0, 0, 1));
  mapping.see_nothing();
  EXPECT_EQ(mapping.state({6.05, 1, 1}), CellState::kUnknown) << "one hit is too few for a finished submap";
  EXPECT_EQ(mapping.state({3, 1, 1}), CellState::kFree);
}

TEST(SubmapMapper, GraphUpdateMovesMapNotSurroundings) {
  SubmapMapping mapping(every_beam());
  mapping.begin_submap(at(0, 0, 1));
  mapping.see({0, 0, 1}, 4);
  // The vehicle comes by again, and its local frame has drifted by a meter.
  mapping.T_local_room = at(1, 0, 0);
  mapping.begin_submap(at(1, 0, 1));
  mapping.see({0, 0, 1}, 4);
  EXPECT_EQ(mapping.state({6.05, 1, 1}), CellState::kOccupied) << "the wall of the first submap";
  EXPECT_EQ(mapping.state({7.05, 1, 1}), CellState::kOccupied) << "the wall of the second submap";
  const std::uint64_t revision = mapping.mapper->map().revision();
  mapping.move_submap(0, at(1, 0, 1));
  EXPECT_NE(mapping.state({6.05, 1, 1}), CellState::kOccupied) << "walls never double";
  EXPECT_EQ(mapping.state({7.05, 1, 1}), CellState::kOccupied);
  EXPECT_GT(mapping.mapper->map().revision(), revision);
}

TEST(SubmapMapper, LoopClosureMovesOldSubmapCells) {
  SubmapMapping mapping(every_beam());
  mapping.begin_submap(at(2, 1, 1));
  mapping.see({0, 0, 1}, 4);
  mapping.begin_submap(at(2, 2, 1));
  mapping.see_nothing();
  const Pose T_moved_from = make_pose({0.4, -0.7, 0.3}, Eigen::Quaterniond(Eigen::AngleAxisd(0.2, Vector3::UnitZ())));
  mapping.move_submap(0, T_moved_from * at(2, 1, 1));
  int on_walls = 0, beside = 0;
  for (double y_m = -4.5; y_m < 4.5; y_m += 0.1) {
    const auto hit =
        mapping.mapper->map().first_hit(T_moved_from * Vector3(0, y_m, 1), T_moved_from * Vector3(8, y_m, 1));
    ASSERT_TRUE(hit) << y_m;
    const double x_m = (T_moved_from.inverse() * hit->center_local_m).x();
    (std::abs(x_m - 6.1) < 0.35 ? on_walls : beside) += 1;
  }
  EXPECT_EQ(beside, 0);
  EXPECT_GT(on_walls, 80);
}

TEST(SubmapMapper, AttachesEarlierScansToFirstSubmap) {
  SubmapMapping mapping(every_beam());
  mapping.see({0, 0, 1}, 4);
  mapping.begin_submap(at(0, 0, 1));
  mapping.see_nothing();
  mapping.begin_submap(at(0, 0, 1));
  mapping.see_nothing();
  mapping.move_submap(0, at(0, 2, 1));
  EXPECT_EQ(mapping.state({1, 8.05, 1}), CellState::kOccupied);
  EXPECT_NE(mapping.state({1, 6.05, 1}), CellState::kOccupied);
}

TEST(SubmapMapper, ContinuesLongSubmapInAnotherPiece) {
  SubmapMapping mapping(every_beam());
  mapping.begin_submap(at(0, 0, 1));
  // From corner to corner are 14 m, more than a piece extends.
  for (const double corner_m : {-5.0, 5.0, -5.0}) mapping.see({corner_m, corner_m, 1}, 4);
  const std::vector<MapPiece> pieces = mapping.pieces();
  EXPECT_EQ(pieces.size(), 3U);
  for (const MapPiece& piece : pieces) EXPECT_EQ(piece.submap, 0);
  mapping.submaps.T_local_own[0] = at(0, 1, 1);
  mapping.begin_submap(at(5, 0, 1));
  mapping.see_nothing();
  EXPECT_EQ(mapping.state({5, 7.05, 1}), CellState::kOccupied) << "all of them move";
  EXPECT_EQ(mapping.state({-5, -5.15, 1}), CellState::kOccupied);
}

TEST(SubmapMapper, ATrackedVehicleIsNoObstacle) {
  SubmapMapping mapping(every_beam());
  mapping.begin_submap(at(0, 0, 1));
  Track track;
  track.position_m = {6.0, 0.0, 1.0};
  for (int i = 0; i < 4; ++i) {
    track.t = mapping.observation.t;
    mapping.see({0, 0, 1.1}, 1, {track});
  }
  EXPECT_NE(mapping.state({6.05, 0.1, 1}), CellState::kOccupied);
  EXPECT_EQ(mapping.state({6.05, 3, 1}), CellState::kOccupied);
}

TEST(SubmapMapper, AddsAnEarlierMapOnceLocated) {
  CellBlock block;
  block.occupied[0] = 1;  // its cell at (0, 0, 0)
  block.free[1] = 1;
  const CellBlock blocks[] = {block};
  const MapPiece given{0, at(0, 0, 3), std::make_shared<const SubmapCells>(0.2, blocks)};
  SubmapMapping mapping;
  mapping.submaps.num_given = 1;
  mapping.begin_submap(at(0, 0, 1));
  mapping.see_nothing();
  EXPECT_EQ(mapping.state({10.1, 0.1, 3.1}), CellState::kUnknown);
  mapping.submaps.T_local_given = {at(10, 0, 0)};
  mapping.submaps.given = {given};
  ++mapping.submaps.revision;
  mapping.see_nothing();
  EXPECT_EQ(mapping.state({10.1, 0.1, 3.1}), CellState::kOccupied);
  EXPECT_EQ(mapping.state({10.1, 0.1, 3.3}), CellState::kFree);
  EXPECT_TRUE(mapping.pieces().empty()) << "the given piece is not its own";
  mapping.submaps.T_local_given = {at(20, 0, 0)};
  ++mapping.submaps.revision;
  mapping.see_nothing();
  EXPECT_EQ(mapping.state({20.1, 0.1, 3.1}), CellState::kOccupied);
  EXPECT_EQ(mapping.state({10.1, 0.1, 3.1}), CellState::kUnknown);
}

std::size_t cells_kept(const SubmapMapping& mapping) {
  std::size_t count = 0;
  for (const MapPiece& piece : mapping.pieces()) count += piece.cells->num_free() + piece.cells->num_occupied();
  return count;
}

TEST(SubmapMapper, MemoryGrowsWithSpaceNotDistance) {
  SubmapMapping mapping(every_beam());
  std::size_t after_two_laps = 0;
  for (int lap = 0; lap < 8; ++lap) {
    for (const Vector3& p_m : {Vector3(-2, -2, 1), Vector3(2, -2, 1), Vector3(2, 2, 1), Vector3(-2, 2, 1)}) {
      mapping.begin_submap(at(p_m.x(), p_m.y(), p_m.z()));
      mapping.see(p_m, 4);
    }
    if (lap == 1) after_two_laps = cells_kept(mapping);
  }
  EXPECT_LT(cells_kept(mapping), after_two_laps * 5 / 4) << "four times the way";
  EXPECT_EQ(mapping.state({6.05, 1, 1}), CellState::kOccupied);
  EXPECT_EQ(mapping.state({3, 1, 1}), CellState::kFree);
}

// The pose graph drops a submap, and its cells hang on an older one. The next submap has its number.
TEST(SubmapMapper, DroppedSubmapsCellsFollowOlderSubmap) {
  SubmapMapping mapping(every_beam());
  mapping.begin_submap(at(0, 0, 1));
  mapping.see({-5, -5, 1});
  mapping.begin_submap(at(1, 0, 1));
  mapping.see({-5, -5, 1}, 4);  // part of the dropped submap is in a finished piece, 14 m away
  mapping.see({5, 5, 1}, 4);
  EXPECT_EQ(mapping.state({6.05, 5, 1}), CellState::kOccupied);
  mapping.submaps.T_local_own.pop_back();
  mapping.submaps.dropped = {1, 1, 0, at(1, 0, 0)};
  mapping.begin_submap(at(2, 0, 1));
  mapping.see_nothing();
  EXPECT_EQ(mapping.state({6.05, 5, 1}), CellState::kOccupied) << "nothing has moved";
  mapping.move_submap(1, at(-20, 0, 1));
  EXPECT_EQ(mapping.state({6.05, 5, 1}), CellState::kOccupied) << "the cell does not move with the newer submap";
  EXPECT_EQ(mapping.state({-5, -6.15, 1}), CellState::kOccupied);
  mapping.move_submap(0, at(0, 2, 1));
  EXPECT_EQ(mapping.state({5, 8.05, 1}), CellState::kOccupied);
  EXPECT_EQ(mapping.state({-5, -4.15, 1}), CellState::kOccupied);
  EXPECT_NE(mapping.state({5, 6.05, 1}), CellState::kOccupied);
  for (const MapPiece& piece : mapping.pieces()) EXPECT_EQ(piece.submap, 0);
}

// Visit after visit the pose graph drops the submap.
TEST(SubmapMapper, RepeatedVisitsMergeIntoFewPieces) {
  SubmapMapperConfig config = every_beam();
  config.covered_share = 1.0;  // otherwise pieces would be thinned
  SubmapMapping few(config), all(config);
  std::size_t most = 0;
  for (std::uint64_t visit = 0; visit < 20; ++visit) {
    const double wiggle_m = 0.07 * static_cast<double>(visit % 5);
    const Vector3 p_m(1.0 + wiggle_m, 1.0 - wiggle_m, 1.0);
    const Pose T = at(p_m.x(), p_m.y(), p_m.z());
    if (visit > 1) {
      few.submaps.dropped = {visit - 1, 1, 0, few.submaps.T_local_own[0].inverse() * few.submaps.T_local_own[1]};
      few.submaps.T_local_own.pop_back();
    }
    for (SubmapMapping* mapping : {&few, &all}) {
      mapping->begin_submap(T);
      mapping->see(p_m, 4);
    }
    most = std::max(most, few.pieces().size());
  }
  EXPECT_LE(most, 6U);
  int known = 0;
  for (double x_m = -7.0; x_m < 7.0; x_m += 0.2) {
    for (double y_m = -7.0; y_m < 7.0; y_m += 0.2) {
      for (const double z_m : {0.5, 1.1, 1.7}) {
        const Vector3 p_m(x_m + 0.1, y_m + 0.1, z_m);
        known += all.state(p_m) != CellState::kUnknown;
        ASSERT_EQ(few.state(p_m), all.state(p_m)) << p_m.transpose();
      }
    }
  }
  EXPECT_GT(known, 5000);
}

TEST(SubmapMapper, ForgetsCellsOfAnUntraceableSubmap) {
  SubmapMapping mapping(every_beam());
  mapping.begin_submap(at(0, 0, 1));
  mapping.see({0, 0, 1}, 4);
  mapping.begin_submap(at(1, 0, 1));
  mapping.see({2, 0, 1});
  mapping.submaps.T_local_own.back() = at(30, 0, 1);
  mapping.submaps.dropped = {2, 1, 0, at(25, 0, 0)};  // two of them since the last step
  ++mapping.submaps.revision;
  mapping.see_nothing();
  ASSERT_EQ(mapping.pieces().size(), 1U);
  EXPECT_EQ(mapping.pieces()[0].submap, 0);
  EXPECT_EQ(mapping.state({6.05, 1, 1}), CellState::kOccupied) << "what the first one saw";
}

TEST(SubmapMapper, ForgetsOldestPieceAndCountsIt) {
  SubmapMapperConfig config = every_beam();
  config.pieces_max = 2;
  config.covered_share = 1.0;
  SubmapMapping mapping(config);
  for (int i = 0; i < 4; ++i) {
    mapping.begin_submap(at(0, 0, 1));
    mapping.see({0, 0, 1}, 3);
  }
  const std::vector<Counter> counters = mapping.counters();
  ASSERT_EQ(counters.size(), 2U);
  EXPECT_EQ(counters[1].setting, "pieces_max");
  EXPECT_EQ(counters[1].count, 1U) << "three are finished";
  EXPECT_EQ(counters[1].of, 3U);
}

TEST(SubmapMapper, RequiresAPoseGraph) {
  Module module(mapper_module_types(), "submaps");
  EXPECT_TRUE(make_mapper(module, {})->needs_submaps());
  EXPECT_FALSE(make_mapper(Module(mapper_module_types(), "occupancy"), {})->needs_submaps());
}

TEST(SubmapMapperConfig, MemoryGrowsWithResolutionAndPieces) {
  SubmapMapperConfig config, finer, more;
  finer.edge_m = 0.5 * config.edge_m;
  more.pieces_max = 2 * config.pieces_max;
  EXPECT_GT(finer.bytes(), 6.0 * config.bytes());
  EXPECT_LT(finer.bytes(), 9.0 * config.bytes());
  EXPECT_GT(more.bytes(), 1.5 * config.bytes());
  EXPECT_LT(more.bytes(), 2.0 * config.bytes());
}

}  // namespace
}  // namespace swiftlet
