// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/map/submap_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

constexpr double kEdge_m = 0.2;
constexpr TimeNs kSubmapScan = kNsPerSecond / 10;

using CellKey = std::array<int, 3>;
CellKey key_of(const Cell& cell) { return {cell.x(), cell.y(), cell.z()}; }
Vector3 center_of(const Cell& cell, double edge_m = kEdge_m) { return (cell.cast<double>().array() + 0.5) * edge_m; }

Pose turned(double x_m, double y_m, double z_m, const Vector3& axis, double angle_rad) {
  return make_pose({x_m, y_m, z_m}, Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, axis.normalized())));
}

/// Cells of a piece by name, before they are packed.
struct Made {
  std::map<CellKey, CellState> states;
  double edge_m = kEdge_m;

  void set(const Cell& cell, CellState state) { states[key_of(cell)] = state; }
  std::shared_ptr<const SubmapCells> packed() const {
    std::map<CellKey, CellBlock> blocks;
    for (const auto& [cell, state] : states) {
      const Cell at(cell[0] >> 3, cell[1] >> 3, cell[2] >> 3);
      CellBlock& block = blocks[key_of(at)];
      block.at = at;
      const std::uint64_t bit = std::uint64_t{1} << ((cell[1] & 7) << 3 | (cell[0] & 7));
      const auto z = static_cast<std::size_t>(cell[2] & 7);
      if (state == CellState::kOccupied) block.occupied[z] |= bit;
      if (state == CellState::kFree) block.free[z] |= bit;
    }
    std::vector<CellBlock> list;
    for (const auto& [at, block] : blocks) list.push_back(block);
    return std::make_shared<const SubmapCells>(edge_m, list);
  }
};

/// Blobs of free space with walls and crumbs in them.
Made random_piece(std::uint32_t seed, double edge_m = kEdge_m) {
  const Random random(seed, "piece");
  Made made;
  made.edge_m = edge_m;
  for (std::uint32_t blob = 0; blob < 3; ++blob) {
    const auto at = [&](std::uint32_t i) { return static_cast<int>(std::floor(random.uniform(-20.0, 20.0, blob, i))); };
    const Cell middle(at(0), at(1), at(2) / 4);
    for (int x = -8; x <= 8; ++x) {
      for (int y = -8; y <= 8; ++y) {
        for (int z = -4; z <= 4; ++z) made.set(middle + Cell(x, y, z), CellState::kFree);
      }
    }
    for (int y = -8; y <= 8; ++y) {
      for (int z = -4; z <= 4; ++z) made.set(middle + Cell(3, y, z), CellState::kOccupied);
    }
    for (std::uint32_t i = 0; i < 40; ++i) {
      const auto off = [&](std::uint32_t axis, double reach) {
        return static_cast<int>(std::floor(random.uniform(-reach, reach, 100 + 3 * i + axis, blob)));
      };
      made.set(middle + Cell(off(0, 9), off(1, 9), off(2, 5)), CellState::kOccupied);
    }
  }
  return made;
}

Pose random_pose(std::uint32_t seed, std::uint32_t i) {
  const Random random(seed, "pose");
  const auto in = [&](double reach, std::uint32_t j) { return random.uniform(-reach, reach, i, j); };
  return turned(in(4, 0), in(4, 1), in(1, 2), Vector3(in(0.1, 3), in(0.1, 4), 1), in(3, 5));
}

std::vector<Cell> cells_of_a_box(int reach_xy, int reach_z) {
  std::vector<Cell> cells;
  for (int z = -reach_z; z <= reach_z; ++z) {
    for (int y = -reach_xy; y <= reach_xy; ++y) {
      for (int x = -reach_xy; x <= reach_xy; ++x) cells.emplace_back(x, y, z);
    }
  }
  return cells;
}

/// Differences of two maps, by cells in a box and by further queries.
int differences(const SubmapMap& a, const SubmapMap& b) {
  int count = 0;
  for (const Cell& cell : cells_of_a_box(45, 12)) count += a.state(center_of(cell)) != b.state(center_of(cell));
  const Random random(1, "queries");
  for (std::uint32_t i = 0; i < 300; ++i) {
    const Vector3 p_m(random.uniform(-10, 10, i, 0), random.uniform(-10, 10, i, 1), random.uniform(-3, 3, i, 2));
    const Vector3 q_m(random.uniform(-10, 10, i, 3), random.uniform(-10, 10, i, 4), random.uniform(-3, 3, i, 5));
    count += a.clearance_m(p_m, 2.0) != b.clearance_m(p_m, 2.0);
    count += a.distance_m(p_m, 1.0) != b.distance_m(p_m, 1.0);
    const auto hit_a = a.first_hit(p_m, q_m), hit_b = b.first_hit(p_m, q_m);
    count += hit_a.has_value() != hit_b.has_value() || (hit_a && hit_a->center_local_m != hit_b->center_local_m);
  }
  return count;
}

TEST(SubmapCells, KnowWhatTheyWereMadeOf) {
  const Made made = random_piece(3);
  const auto cells = made.packed();
  std::size_t occupied = 0, free = 0;
  for (const auto& [cell, state] : made.states) {
    const Cell at(cell[0] >> 3, cell[1] >> 3, cell[2] >> 3);
    const int i = cells->find(at);
    ASSERT_GE(i, 0);
    EXPECT_EQ(cells->at(i), at);
    (state == CellState::kOccupied ? occupied : free) += 1;
  }
  EXPECT_EQ(cells->num_occupied(), occupied);
  EXPECT_EQ(cells->num_free(), free);
  EXPECT_EQ(cells->find({1000, 0, 0}), -1);
  for (int i = 0; i < static_cast<int>(cells->num_blocks()); ++i) {
    const Vector3 corner_m = 8 * kEdge_m * cells->at(i).cast<double>();
    EXPECT_LE((corner_m - cells->middle_m()).norm(), cells->reach_m() + 1e-9);
  }
}

TEST(SubmapCells, CoverExactlyTheirPoints) {
  const Eigen::Vector3f points_m[] = {{0.1F, 0.1F, 0.1F}, {-0.1F, 3.3F, -5.5F}, {0.15F, 0.05F, 0.19F}, {7.7F, 0, 0}};
  const SubmapCells cells = SubmapCells::of_points(kEdge_m, points_m);
  EXPECT_EQ(cells.num_occupied(), 3U);
  EXPECT_EQ(cells.num_free(), 0U);
  const auto map = make_submap_map({});
  map->add(std::make_shared<const SubmapCells>(cells), Pose::Identity(), 0, 0);
  for (const Eigen::Vector3f& p_m : points_m) EXPECT_EQ(map->state(p_m.cast<double>()), CellState::kOccupied);
  EXPECT_EQ(map->state({0.3, 0.1, 0.1}), CellState::kUnknown);
}

// The released code of [Orsulic 2021] puts the cells of a submap half a cell off.
TEST(SubmapMap, KeepsCellsInPlaceWithoutRotation) {
  Made made;
  made.set({5, -3, 2}, CellState::kOccupied);
  const auto map = make_submap_map({});
  map->add(made.packed(), Pose::Identity(), 0, 0);
  std::vector<Vector3> centers_m;
  map->append_occupied(centers_m);
  ASSERT_EQ(centers_m.size(), 1U);
  EXPECT_LT((centers_m[0] - Vector3(1.1, -0.5, 0.5)).norm(), 1e-12);
}

TEST(SubmapMap, RotatesEveryCellByRightAngles) {
  Made made;
  for (const int x : {-1, 0}) {
    for (const int y : {-1, 0}) made.set({8 * x, 8 * y, 0}, CellState::kFree);  // blocks about the origin
  }
  made.set({5, 2, 3}, CellState::kOccupied);
  const auto map = make_submap_map({});
  const int piece = map->add(made.packed(), turned(0, 0, 0, Vector3::UnitZ(), 0.5 * M_PI), 0, 0);
  EXPECT_EQ(map->T_local_cells(piece).translation().head<2>(), Vector3::Zero().head<2>());
  EXPECT_EQ(map->state(center_of({-3, 5, 3})), CellState::kOccupied);
  EXPECT_EQ(map->state(center_of({5, 2, 3})), CellState::kUnknown);
}

// No obstacle is lost by any rotation and for any edge of the piece, and none is added away from one.
TEST(SubmapMap, ContainsTheObstaclesOfItsPieces) {
  std::vector<Made> made;
  const auto map = make_submap_map({kEdge_m, 0, 2.0});
  std::vector<Vector3> obstacles_m;
  for (std::uint32_t i = 0; i < 5; ++i) {
    made.push_back(random_piece(10 + i, i == 3 ? 0.1 : i == 4 ? 0.3 : kEdge_m));
    const Pose T = map->T_local_cells(map->add(made[i].packed(), random_pose(5, i), 0, 0));
    for (const auto& [cell, state] : made[i].states) {
      const Vector3 p_m = T * center_of({cell[0], cell[1], cell[2]}, made[i].edge_m);
      if (state == CellState::kOccupied) obstacles_m.push_back(p_m);
    }
  }
  for (const Vector3& p_m : obstacles_m) ASSERT_EQ(map->state(p_m), CellState::kOccupied) << p_m.transpose();
  std::vector<Vector3> occupied_m;
  map->append_occupied(occupied_m);
  EXPECT_GT(occupied_m.size(), 500U);
  const double reach_m = 0.5 * std::sqrt(3.0) * (kEdge_m + 0.3);
  for (const Vector3& c_m : occupied_m) {
    ASSERT_TRUE(std::any_of(obstacles_m.begin(), obstacles_m.end(),
                            [&](const Vector3& p_m) { return (p_m - c_m).norm() <= reach_m; }));
  }
}

TEST(SubmapMap, CopiesEveryKnownCell) {
  const auto map = make_submap_map({});
  for (std::uint32_t i = 0; i < 3; ++i) map->add(random_piece(20 + i).packed(), random_pose(8, i), 0, 0);
  MapVoxels copy;
  map->append_voxels(copy);
  std::map<CellKey, CellState> copied;
  for (std::size_t i = 0; i < copy.size(); ++i) {
    const Cell cell = (copy.centers_local_m[i].cast<double>() / kEdge_m).array().floor().cast<int>();
    copied[key_of(cell)] = copy.state[i] == copy.occupied_from ? CellState::kOccupied : CellState::kFree;
  }
  EXPECT_EQ(copied.size(), copy.size()) << "each once";
  std::size_t known = 0;
  for (const Cell& cell : cells_of_a_box(64, 24)) {
    const CellState state = map->state(center_of(cell));
    if (state == CellState::kUnknown) continue;
    ++known;
    ASSERT_TRUE(copied.contains(key_of(cell)));
    EXPECT_EQ(copied[key_of(cell)], state);
  }
  EXPECT_EQ(known, copy.size());
}

TEST(SubmapMap, RoundsPosesToAQuarterCell) {
  const auto cells = random_piece(2).packed();
  for (std::uint32_t i = 0; i < 50; ++i) {
    const auto map = make_submap_map({});
    const Pose T = random_pose(7, i);
    const Pose& used = map->T_local_cells(map->add(cells, T, 0, 0));
    EXPECT_LT(((used * cells->middle_m() - T * cells->middle_m()).cwiseAbs().maxCoeff()), 0.126 * kEdge_m);
    for (int b = 0; b < static_cast<int>(cells->num_blocks()); ++b) {
      const Vector3 p_m = 8 * kEdge_m * cells->at(b).cast<double>();
      EXPECT_LT((used * p_m - T * p_m).norm(), 0.5 * kEdge_m);
    }
  }
}

// A jittering pose moves nothing.
TEST(SubmapMap, IgnoresSubcellPoseChanges) {
  const auto cells = random_piece(2).packed();
  for (int axis = 0; axis < 3; ++axis) {
    const auto map = make_submap_map({});
    const Vector3 about = Vector3::Unit(axis);
    const int piece = map->add(cells, turned(0.31, 0.12, 0.07, about, 0.003), 0, 0);
    EXPECT_FALSE(map->move(piece, turned(0.312, 0.121, 0.071, about, 0.0031))) << axis;
    EXPECT_TRUE(map->move(piece, turned(0.312, 0.121, 0.071, about, 0.1))) << axis;
  }
}

TEST(SubmapMap, FindsEveryCellOfDistantPieces) {
  Made made;
  made.set({1, 2, 3}, CellState::kOccupied);
  const auto cells = made.packed();
  const auto map = make_submap_map({});
  const double step_m = 64 * kEdge_m;
  for (int i = 0; i < 1500; ++i) {
    map->add(cells, turned(step_m * (i % 40), step_m * (i / 40), 0, Vector3::UnitZ(), 0.0), 0, 0);
  }
  for (int i = 0; i < 1500; ++i) {
    const Vector3 at_m(step_m * (i % 40), step_m * (i / 40), 0.0);
    ASSERT_EQ(map->state(at_m + center_of({1, 2, 3})), CellState::kOccupied) << i;
    ASSERT_EQ(map->state(at_m + center_of({2, 2, 3})), CellState::kUnknown) << i;
  }
}

// After any sequence of changes the map depends only on its present pieces.
TEST(SubmapMap, MatchesRebuiltMapsAfterChanges) {
  for (std::uint32_t seed = 0; seed < 2; ++seed) {
    const Random random(seed, "changes");
    const auto map = make_submap_map({});
    struct Lying {
      int piece;
      std::shared_ptr<const SubmapCells> cells;
      Pose T;
      int age;
    };
    std::vector<Lying> lying;
    std::unique_ptr<OccupancyMap> growing;
    OccupancyMapConfig growing_config;
    growing_config.edge_m = kEdge_m;
    Cell offset = Cell::Zero();
    std::uint32_t next = 0;
    for (std::uint32_t step = 0; step < 25; ++step) {
      const double what = random.uniform(0, 1, step, 0);
      const auto pick = static_cast<std::size_t>(random.uniform(0, 1, step, 1) * static_cast<double>(lying.size()));
      const std::uint64_t before = map->revision();
      std::vector<CellState> states;
      const std::vector<Cell> box = cells_of_a_box(25, 8);
      for (const Cell& cell : box) states.push_back(map->state(center_of(cell)));
      if (what < 0.4 || lying.empty()) {
        const auto cells = random_piece(seed * 100 + next).packed();
        const Pose T = next % 3 == 0 ? turned(1.6 * next, 0, 0, Vector3::UnitZ(), 0) : random_pose(seed, next);
        lying.push_back({map->add(cells, T, static_cast<int>(next % 2), 0), cells, T, static_cast<int>(next % 2)});
        ++next;
      } else if (what < 0.7) {
        lying[pick].T = random_pose(seed + 50, step) * lying[pick].T;
        map->move(lying[pick].piece, lying[pick].T);
      } else if (what < 0.8) {
        map->remove(lying[pick].piece);
        lying.erase(lying.begin() + static_cast<std::ptrdiff_t>(pick));
      } else if (what < 0.87 && growing != nullptr) {
        map->set_growing(nullptr, Cell::Zero());
        growing.reset();
      } else {
        if (growing == nullptr) {
          growing = make_occupancy_map(growing_config);
          offset = Cell(static_cast<int>(step % 3) - 1, 1, 0);
        }
        std::vector<OccupancyMap::Ray> rays;
        for (std::uint32_t i = 0; i < 200; ++i) {
          const auto n = random.normal3(10 + step, i);
          rays.push_back(
              {Eigen::Vector3f(0.1F, 0.1F, 0.1F), (3.0 * Vector3(n[0], n[1], 0.3 * n[2])).cast<float>(), true});
        }
        growing->insert(rays, step * kSubmapScan);
        map->set_growing(growing.get(), offset);
      }
      const auto anew = make_submap_map({});
      for (const Lying& piece : lying) anew->add(piece.cells, piece.T, piece.age, 0);
      anew->set_growing(growing.get(), offset);
      ASSERT_EQ(differences(*map, *anew), 0) << "seed " << seed << ", step " << step;
      EXPECT_EQ(map->num_pieces(), static_cast<int>(lying.size()));
      // The map also reports where it changed.
      std::vector<VoxelGrid> boxes;
      ASSERT_TRUE(map->changed_since(before, boxes));
      for (std::size_t i = 0; i < box.size(); ++i) {
        if (map->state(center_of(box[i])) == states[i]) continue;
        ASSERT_TRUE(std::any_of(boxes.begin(), boxes.end(), [&](const VoxelGrid& g) { return g.contains(box[i]); }));
      }
    }
  }
}

TEST(SubmapMap, OnlyWhatMovedIsMadeAnew) {
  const auto map = make_submap_map({});
  std::vector<int> pieces;
  std::vector<Pose> poses;
  for (std::uint32_t i = 0; i < 20; ++i) {
    poses.push_back(turned(40.0 * i + 0.05, 0.05, 0.05, Vector3::UnitZ(), 0.0));
    pieces.push_back(map->add(random_piece(i).packed(), poses.back(), 0, 0));
  }
  const auto ask_all = [&] {
    for (const Pose& T : poses) {
      for (const Cell& cell : cells_of_a_box(30, 8)) map->state(T.translation() + center_of(cell));
    }
  };
  ask_all();
  const std::uint64_t composed = map->num_composed();
  ask_all();
  EXPECT_EQ(map->num_composed(), composed) << "nothing is composed twice";
  // All by a hair, three by a meter.
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const bool far = i == 3 || i == 4 || i == 15;
    map->move(pieces[i], Pose(Eigen::Translation3d(far ? 1.0 : 0.01, 0.0, 0.0)) * poses[i]);
  }
  EXPECT_EQ(map->num_moved(), 3U);
  ask_all();
  EXPECT_LT(map->num_composed() - composed, composed / 5) << "blocks of three pieces of twenty";
  EXPECT_GT(map->num_composed() - composed, composed / 20);
}

/// A round corridor, seen in submaps by a vehicle that drifts: walls at 8 m and 12 m from the middle.
struct Ring {
  static constexpr int kSubmaps = 24, kLap = 12;  // two laps
  static Vector3 place_world_m(int i) {
    const double a = 2.0 * M_PI * i / kLap;
    return {10.0 * std::cos(a), 10.0 * std::sin(a), 1.0};
  }
  static Pose T_world_submap(int i) {
    return make_pose(place_world_m(i), Eigen::Quaterniond(Eigen::AngleAxisd(2.0 * M_PI * i / kLap, Vector3::UnitZ())));
  }
  /// Pose with drift: 3 cm and a tenth of a degree per submap.
  static Pose T_local_submap(int i) {
    return turned(0.03 * i, 0.02 * i, 0.005 * i, Vector3::UnitZ(), 0.002 * i) * T_world_submap(i);
  }
  static Made seen_from(int i) {
    Made made;
    const Pose T = T_world_submap(i);
    for (const Cell& cell : cells_of_a_box(30, 5)) {
      const Vector3 p_world_m = T * center_of(cell);
      const double r_m = p_world_m.head<2>().norm();
      if (r_m > 8.2 && r_m < 11.8) made.set(cell, CellState::kFree);
    }
    for (int k = 0; k < 3000; ++k) {
      for (const double r_m : {8.0, 12.0}) {
        for (int z = 0; z < 11; ++z) {
          const Vector3 p_world_m(r_m * std::cos(2e-3 * M_PI / 3 * k), r_m * std::sin(2e-3 * M_PI / 3 * k), 0.2 * z);
          const Vector3 p_m = T.inverse() * p_world_m;
          if (p_m.norm() < 5.5) made.set((p_m / kEdge_m).array().floor().cast<int>(), CellState::kOccupied);
        }
      }
    }
    return made;
  }
  /// The farthest occupied cell from a wall.
  static double worst_m(const SubmapMap& map, const Pose& T_world_local) {
    std::vector<Vector3> centers_m;
    map.append_occupied(centers_m);
    double worst_m = 0.0;
    for (const Vector3& p_local_m : centers_m) {
      const double r_m = (T_world_local * p_local_m).head<2>().norm();
      worst_m = std::max(worst_m, std::min(std::abs(r_m - 8.0), std::abs(r_m - 12.0)));
    }
    return worst_m;
  }
};

TEST(SubmapMap, DoublesWallsOnlyUntilLoopClosure) {
  const auto map = make_submap_map({kEdge_m, 0, 2.0});
  std::vector<int> pieces;
  for (int i = 0; i < Ring::kSubmaps; ++i) {
    pieces.push_back(map->add(Ring::seen_from(i).packed(), Ring::T_local_submap(i), 0, 0));
  }
  // In the local frame the newest submap stands still.
  const int last = Ring::kSubmaps - 1;
  const Pose T_world_local = Ring::T_world_submap(last) * Ring::T_local_submap(last).inverse();
  EXPECT_GT(Ring::worst_m(*map, T_world_local), 0.6);
  const std::uint64_t before = map->revision();
  for (int i = 0; i < Ring::kSubmaps; ++i) map->move(pieces[i], T_world_local.inverse() * Ring::T_world_submap(i));
  EXPECT_FALSE(map->move(pieces[last], Ring::T_local_submap(last)));
  EXPECT_GT(map->revision(), before);
  // A cell in the submap, one in the map, and what poses are rounded to.
  EXPECT_LT(Ring::worst_m(*map, T_world_local), 2.2 * kEdge_m);
  for (int i = 0; i < 360; ++i) {
    const double a = i * M_PI / 180.0;
    const auto at = [&](double r_m) {
      return Vector3(T_world_local.inverse() * Vector3(r_m * std::cos(a), r_m * std::sin(a), 1.0));
    };
    EXPECT_EQ(map->state(at(10.0)), CellState::kFree) << i;
    EXPECT_TRUE(map->first_hit(at(10.0), at(12.6))) << "no hole in the wall at " << i << " degrees";
    EXPECT_TRUE(map->first_hit(at(10.0), at(7.4))) << "no hole in the wall at " << i << " degrees";
  }
}

TEST(SubmapMap, RotatesThinObjectsAndWallsIntact) {
  for (int degrees = 0; degrees < 180; degrees += 13) {
    Made made;
    for (int y = -15; y <= 15; ++y) {
      for (int z = -10; z <= 10; ++z) made.set({10, y, z}, CellState::kOccupied);
    }
    for (int z = -10; z <= 10; ++z) made.set({-10, 3, z}, CellState::kOccupied);  // a pole
    const auto map = make_submap_map({});
    const Pose& T = map->T_local_cells(
        map->add(made.packed(), turned(0.07, -0.13, 0.04, Vector3(0.1, 0.05, 1), degrees * M_PI / 180.0), 0, 0));
    for (int i = 0; i < 400; ++i) {
      const double y_m = 0.2 * (i % 20 - 10), z_m = 0.15 * (i / 20 - 10);
      EXPECT_TRUE(map->first_hit(T * Vector3(0, y_m, z_m), T * Vector3(3, y_m, z_m))) << degrees;
    }
    for (int z = -10; z <= 10; ++z) {
      EXPECT_EQ(map->state(T * center_of({-10, 3, z})), CellState::kOccupied) << degrees;
    }
  }
}

TEST(SubmapMap, ClearsCellsSeenFreeLater) {
  Made occupied, free;
  occupied.set({1, 1, 1}, CellState::kOccupied);
  free.set({1, 1, 1}, CellState::kFree);
  const Vector3 p_m = center_of({1, 1, 1});
  const auto state_after = [&](int outvoted_by, const char* pieces) {
    const auto map = make_submap_map({kEdge_m, outvoted_by, 2.0});
    for (const char* c = pieces; *c != 0; ++c) {
      map->add((*c == 'o' ? occupied : free).packed(), Pose::Identity(), 0, 0);
    }
    return map->state(p_m);
  };
  EXPECT_EQ(state_after(2, "of"), CellState::kOccupied);
  EXPECT_EQ(state_after(2, "off"), CellState::kFree);
  EXPECT_EQ(state_after(2, "ofof"), CellState::kOccupied);
  EXPECT_EQ(state_after(2, "offo"), CellState::kOccupied);
  EXPECT_EQ(state_after(2, "ffo"), CellState::kOccupied) << "older pieces do not count";
  EXPECT_EQ(state_after(1, "of"), CellState::kFree);
  EXPECT_EQ(state_after(3, "off"), CellState::kOccupied);
  EXPECT_EQ(state_after(3, "offf"), CellState::kFree);
  EXPECT_EQ(state_after(0, "offffffff"), CellState::kOccupied);
}

TEST(SubmapMap, OrdersPiecesByAgeBeforeArrival) {
  Made occupied, free;
  occupied.set({1, 1, 1}, CellState::kOccupied);
  free.set({1, 1, 1}, CellState::kFree);
  const auto map = make_submap_map({kEdge_m, 1, 2.0});
  map->add(free.packed(), Pose::Identity(), 1, 0);
  map->add(occupied.packed(), Pose::Identity(), 0, 0);  // piece of an earlier flight
  EXPECT_EQ(map->state(center_of({1, 1, 1})), CellState::kFree);
}

// Removing cells that newer pieces contain leaves the map unchanged.
TEST(SubmapMap, IsUnchangedWithoutRedundantCells) {
  const auto map = make_submap_map({});
  const auto whole = make_submap_map({});
  std::vector<int> pieces;
  std::size_t cells_before = 0, cells_after = 0;
  for (std::uint32_t lap = 0; lap < 4; ++lap) {
    for (std::uint32_t i = 0; i < 4; ++i) {
      const auto cells = random_piece(i).packed();
      const Pose T = random_pose(3, i) * turned(0.03 * lap, 0.0, 0.0, Vector3::UnitZ(), 0.01 * lap);
      pieces.push_back(map->add(cells, T, 0, 0));
      whole->add(cells, T, 0, 0);
      cells_before += cells->num_free() + cells->num_occupied();
    }
  }
  EXPECT_GT(map->share_known_by_newer(pieces[0], 1), 0.9) << "share of the first piece that three newer ones know";
  EXPECT_EQ(map->share_known_by_newer(pieces.back(), 1), 0.0);
  for (const int piece : pieces) {
    const auto needed = map->needed_of(piece);
    cells_after += needed->num_free() + needed->num_occupied();
    map->replace(piece, needed);
  }
  EXPECT_EQ(differences(*map, *whole), 0);
  EXPECT_LT(cells_after, cells_before * 2 / 5);
  EXPECT_GT(cells_after, cells_before / 5);
}

TEST(SubmapMap, SelectsCellsByTheTimeSeen) {
  Made old, young;
  old.set({1, 1, 1}, CellState::kOccupied);
  young.set({5, 1, 1}, CellState::kOccupied);
  const auto map = make_submap_map({});
  map->add(old.packed(), Pose::Identity(), 0, 10 * kSubmapScan);
  map->add(young.packed(), Pose::Identity(), 0, 20 * kSubmapScan);
  OccupancyMapConfig config;
  config.edge_m = kEdge_m;
  const auto growing = make_occupancy_map(config);
  const OccupancyMap::Ray ray{{0.1F, 0.1F, 0.1F}, {0.1F, 1.9F, 0.1F}, true};
  growing->insert({&ray, 1}, 30 * kSubmapScan);
  map->set_growing(growing.get(), Cell(0, 0, 0));
  const auto seen_since = [&](TimeNs since) {
    std::vector<Vector3> centers_m;
    map->occupied_within(Vector3::Zero(), 5.0, since, centers_m);
    return centers_m.size();
  };
  EXPECT_EQ(seen_since(kEver), 3U);
  EXPECT_EQ(seen_since(10 * kSubmapScan), 3U);
  EXPECT_EQ(seen_since(15 * kSubmapScan), 2U);
  EXPECT_EQ(seen_since(25 * kSubmapScan), 1U);
  EXPECT_EQ(seen_since(31 * kSubmapScan), 0U);
}

TEST(SubmapMap, ReportsClearanceAlsoAfterAMove) {
  const auto map = make_submap_map({});
  const int piece = map->add(random_piece(1).packed(), random_pose(1, 1), 0, 0);
  map->add(random_piece(2).packed(), random_pose(1, 2), 0, 0);
  for (int round = 0; round < 3; ++round) {
    std::vector<Vector3> occupied_m;
    map->append_occupied(occupied_m);
    for (const Cell& cell : cells_of_a_box(12, 4)) {
      double least_m = 2.0;
      for (const Vector3& p_m : occupied_m) least_m = std::min(least_m, (p_m - center_of(cell)).norm());
      ASSERT_NEAR(map->clearance_m(center_of(cell), 2.0), least_m, 1e-9);
    }
    map->move(piece, random_pose(2, static_cast<std::uint32_t>(round)));
  }
}

}  // namespace
}  // namespace swiftlet
