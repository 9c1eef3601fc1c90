// SPDX-License-Identifier: BSD-3-Clause
// What a scan says of the pose, written down once more without any care for speed, on random places.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/slam/scan_to_map.hpp"
#include "tests/core/slam/plain_planes.hpp"

namespace swiftlet {
namespace {

using Twist = Eigen::Matrix<double, 6, 1>;

struct PlainScan {
  const SurfaceMap& map;
  const std::vector<Eigen::Vector3f>& points;
  Pose T;
  ScanToMapConfig config;
  double floor_m2() const { return config.surface_sigma_m * config.surface_sigma_m; }
  double robust(double distance_sq) const {
    const double k = config.kernel_sigma * config.kernel_sigma;
    return k * k / ((k + distance_sq) * (k + distance_sq));
  }
};

double plane_variance(const PlainScan& scan, const SurfaceCell& cell, const Vector3& off) {
  const double r = cell.normal.cast<double>().dot(off), n = cell.count_fitted, v = cell.variance_m2;
  return scan.floor_m2() + v + v / n + (off.squaredNorm() - r * r) * v / (n * cell.narrow_variance_m2);
}

/// Of a point that moves by n along n: three rows for a direction, three for a turn in body axes.
Twist row_of(const PlainScan& scan, const Vector3& x, const Vector3& n) {
  Twist J;
  J << n, x.cross(scan.T.linear().transpose() * n);
  return J;
}

bool lies_on_nothing(const PlainScan& scan, const Vector3& at) {
  const SurfaceCell* cell = scan.map.find(at);
  if (cell == nullptr) return true;
  const Vector3 off = at - cell->mean_m.cast<double>();
  const double across = cell->normal.cast<double>().dot(off);
  if (cell->planar) return across * across / plane_variance(scan, *cell, off) > 9.0;
  if (std::sqrt(cell->narrow_variance_m2) > 0.15) return true;
  const double aside = cell->aside().cast<double>().dot(off);
  return across * across / (scan.floor_m2() + cell->variance_m2) > 9.0 ||
         aside * aside / (scan.floor_m2() + cell->narrow_variance_m2) > 9.0;
}

/// Does any beam end half a meter or more behind the surface through x along these two, having gone through it within
/// 1.5 m of x along each?
bool a_beam_goes_by(const PlainScan& scan, const Vector3& x, const Vector3& along, const Vector3& aside) {
  Vector3 normal = along.cross(aside).normalized();
  if (normal.dot(x) < 0.0) normal = -normal;  // away from the sensor
  for (const Eigen::Vector3f& point : scan.points) {
    const Vector3 end = point.cast<double>();
    const double behind_m = normal.dot(end - x);
    if (behind_m < 0.5) continue;
    const Vector3 through = end * (normal.dot(x) / normal.dot(end)) - x;
    if (std::abs(along.dot(through)) < 1.5 && std::abs(aside.dot(through)) < 1.5) return true;
  }
  return false;
}

ScanFit plain_fit(const SurfaceMap& map, const std::vector<Eigen::Vector3f>& points, const Pose& T,
                  const ScanToMapConfig& config, double smear_m, double range_sigma_m) {
  const PlainScan scan{map, points, T, config};
  const Matrix3 R = T.linear();
  ScanFit fit;
  fit.num_points = static_cast<int>(points.size());
  Matrix6 of_planes = Matrix6::Zero(), all = Matrix6::Zero();
  Twist gradient = Twist::Zero();
  double weight = 0.0, lever_m2 = 0.0, noise = 0.0, of_scan = 0.0, of_map = 0.0, renewed = 0.0;
  testing::PlainPlanes met;
  for (const Eigen::Vector3f& point : points) {
    const Vector3 x = point.cast<double>(), at = T * x;
    const SurfaceCell* cell = map.find(at);
    if (cell == nullptr) continue;
    ++fit.num_known;
    fit.num_fresh += map.is_full(*cell) ? 0 : 1;
    const Vector3 off = at - cell->mean_m.cast<double>();
    if (cell->planar) {
      ++fit.num_planar;
      const Vector3 n = cell->normal.cast<double>();
      const double r = n.dot(off), variance = plane_variance(scan, *cell, off);
      if (std::abs(r) > config.reach_m) continue;
      fit.num_near += r * r < 9.0 * variance ? 1 : 0;
      met.add(*cell, off, scan.robust(r * r / variance) / (scan.floor_m2() + cell->variance_m2));
    } else if (config.point_weight > 0.0) {
      const double variance = scan.floor_m2() + cell->variance_m2 + cell->narrow_variance_m2 + cell->narrow_variance_m2;
      fit.num_near += off.squaredNorm() < 9.0 * variance ? 1 : 0;
      const double w = config.point_weight * scan.robust(off.squaredNorm() / variance) / variance;
      for (int axis = 0; axis < 3; ++axis) {
        const Twist J = row_of(scan, x, Vector3::Unit(axis));
        all += w * J * J.transpose();
        gradient += w * off[axis] * J;
      }
    }
  }
  for (const testing::PlainPlane& plane : met.all()) {
    const Vector3 n = plane.cell->normal.cast<double>(), mean = plane.cell->mean_m.cast<double>();
    const Vector3 unsure = plane.variances(scan.floor_m2(), range_sigma_m, T.translation());
    const Eigen::MatrixXd S_inverse = plane.covariance(unsure).inverse();
    const Eigen::MatrixX3d A = plane.regressors();
    const Matrix3 W = A.transpose() * S_inverse * A;
    Eigen::MatrixXd J(plane.off_m.size(), 6);
    Eigen::VectorXd r(plane.off_m.size());
    double information = 0.0;
    for (std::size_t i = 0; i < plane.off_m.size(); ++i) {
      J.row(i) = row_of(scan, T.inverse() * (mean + plane.off_m[i]), n).transpose();
      r(i) = n.dot(plane.off_m[i]);
      information += plane.information[i];
    }
    of_planes += J.transpose() * S_inverse * J;
    all += J.transpose() * S_inverse * J;
    gradient += J.transpose() * S_inverse * r;
    weight += W(0, 0);
    lever_m2 += W(0, 0) * (mean - T.translation()).squaredNorm();
    noise += W(0, 0) * unsure.z();
    of_scan += information;
    of_map += (W * unsure.asDiagonal() * W)(0, 0);
    if (!map.is_full(*plane.cell)) renewed += information - W(0, 0);
  }
  if (weight <= 0.0) {
    fit.num_degenerate = 6;
    return fit;
  }

  fit.map_share = of_map / weight;
  fit.renewal = renewed / of_scan;

  // Turns are counted by the mean lever arm.
  Twist scale = Twist::Ones();
  scale.tail<3>().setConstant(std::sqrt(lever_m2 / weight));
  const Matrix6 S = scale.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(S * of_planes * S);
  std::vector<Twist> weak;
  Matrix6 keep = Matrix6::Identity();
  for (int i = 0; i < 6; ++i) {
    if (eigen.eigenvalues()(i) >= std::max(config.degenerate_share * weight, 3.0 * noise)) continue;
    weak.push_back(eigen.eigenvectors().col(i));
    keep -= weak.back() * weak.back().transpose();
  }
  Matrix6 H = all;
  Twist g = gradient;
  if (!weak.empty()) {
    struct Standing {
      Twist J;
      double r, w;
      std::vector<bool> free;
    };
    std::vector<Standing> standing;
    std::vector<int> num(weak.size(), 0), passed(weak.size(), 0);
    for (const Eigen::Vector3f& point : points) {
      const Vector3 x = point.cast<double>(), at = T * x;
      const SurfaceCell* cell = map.find(at);
      if (cell != nullptr && !cell->planar) cell = map.find_pole(at);
      if (cell == nullptr) continue;
      const Vector3 off = at - cell->mean_m.cast<double>();
      std::vector<Vector3> normals = {cell->normal.cast<double>()};
      std::vector<double> variances = {plane_variance(scan, *cell, off)};
      if (!cell->planar) {
        const double more = (cell->count_fitted + 1.0) / cell->count_fitted;
        normals.emplace_back(cell->aside().cast<double>());
        variances = {scan.floor_m2() + cell->variance_m2 * more, scan.floor_m2() + cell->narrow_variance_m2 * more};
      }
      double distance_sq = 0.0;
      for (std::size_t k = 0; k < normals.size(); ++k) distance_sq += std::pow(normals[k].dot(off), 2) / variances[k];
      if (distance_sq > 9.0) continue;
      std::vector<bool> free(weak.size(), false);
      for (std::size_t i = 0; i < weak.size(); ++i) {
        const Twist twist = S * weak[i];
        const Vector3 motion = twist.head<3>() + R * twist.tail<3>().cross(x), along = motion.normalized();
        double across = 0.0;
        for (const Vector3& n : normals) across = std::max(across, std::abs(n.dot(along)));
        if (motion.norm() < 0.25 || across < 0.3) continue;
        if (!lies_on_nothing(scan, at + 0.7 * along) || !lies_on_nothing(scan, at - 0.7 * along)) continue;
        free[i] = true;
        ++num[i];
        Vector3 aside = cell->planar ? Vector3(normals[0].cross(along)) : Vector3(cell->axis.cast<double>());
        if (aside.norm() < 0.3) aside = along.unitOrthogonal();
        aside = (aside - aside.dot(along) * along).normalized();
        passed[i] += a_beam_goes_by(scan, x, R.transpose() * along, R.transpose() * aside) ? 1 : 0;
      }
      if (std::none_of(free.begin(), free.end(), [](bool is) { return is; })) continue;
      for (std::size_t k = 0; k < normals.size(); ++k) {
        standing.push_back(
            {S * row_of(scan, x, normals[k]), normals[k].dot(off), scan.robust(distance_sq) / variances[k], free});
      }
    }
    std::vector<bool> holds(weak.size());
    for (std::size_t i = 0; i < weak.size(); ++i) {
      holds[i] = num[i] >= config.standing_points && passed[i] >= 3;
      ++(holds[i] ? fit.num_held : fit.num_degenerate);
    }
    H = keep * S * all * S * keep;
    g = keep * S * gradient;
    for (const Standing& s : standing) {
      Matrix6 open = keep;
      bool any = false;
      for (std::size_t i = 0; i < weak.size(); ++i) {
        if (!holds[i] || !s.free[i]) continue;
        any = true;
        open += weak[i] * weak[i].transpose();
      }
      if (!any) continue;
      H += s.w * open * s.J * s.J.transpose() * open;
      g += s.w * s.r * open * s.J;
    }
    H = S.inverse() * H * S.inverse();
    g = S.inverse() * g;
  }

  // What all points have in common: its covariance is added to that of the pose, sixty times as far where some is open.
  const double times = fit.num_degenerate > 0 ? 60.0 : 1.0;
  Twist F;
  F.head<3>().setConstant(std::pow(times * config.floor_position_m, 2) + smear_m * smear_m);
  F.tail<3>().setConstant(std::pow(times * config.floor_attitude_deg * kRadPerDeg, 2));
  const Matrix6 less = (Matrix6::Identity() + H * F.asDiagonal()).inverse();
  fit.evidence.information = less * H;
  fit.evidence.gradient = less * g;
  return fit;
}

/// A random place: ground, stems, pieces of walls and bushes, seen from above it.
struct RandomPlace {
  std::mt19937 random;
  std::vector<std::array<double, 4>> stems;  // x, y, radius, top
  std::vector<std::array<double, 5>> walls;  // x, y, heading, length, top
  std::vector<Vector3> bushes;
  bool has_ground = true, is_aisle = false;

  explicit RandomPlace(unsigned seed) : random(seed) {
    const auto draw = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    is_aisle = seed % 4 == 3;
    has_ground = seed % 8 != 1;
    const int num_stems = static_cast<int>(seed % 5) * 2, num_walls = static_cast<int>(seed / 2 % 4);
    for (int i = 0; i < num_stems; ++i) {
      stems.push_back({draw(-10, 10), draw(-10, 10), draw(0.05, 0.25), draw(0.5, 3.0)});
    }
    for (int i = 0; i < num_walls; ++i) {
      walls.push_back({draw(-8, 8), draw(-8, 8), draw(0, M_PI), draw(0.4, 3.0), draw(0.5, 2.5)});
    }
    if (is_aisle) {
      walls.push_back({0.0, 3.1, 0.05, 24.0, 2.0});
      walls.push_back({0.0, -3.4, 0.05, 24.0, 2.0});
    }
    for (unsigned i = 0; i < seed % 3; ++i) bushes.emplace_back(draw(-9, 9), draw(-9, 9), -1.0);
  }

  std::vector<Vector3> points(int num) {
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    std::normal_distribution<double> normal(0.0, 0.02);
    const auto u = [&] { return uniform(random); };
    const auto n = [&] { return normal(random); };
    std::vector<Vector3> out;
    const std::size_t kinds = 1 + stems.size() + walls.size() + bushes.size();
    for (int i = 0; i < num; ++i) {
      std::size_t kind = static_cast<std::size_t>(static_cast<double>(kinds + 3) * u());
      if (kind < stems.size()) {
        const auto& [x, y, r, top] = stems[kind];
        const double a = 2.0 * M_PI * u();
        out.emplace_back(x + r * std::cos(a) + n(), y + r * std::sin(a) + n(), -2.0 + (top + 2.0) * u());
        continue;
      }
      kind -= stems.size();
      if (kind < walls.size()) {
        const auto& [x, y, heading, length, top] = walls[kind];
        const double along = length * (u() - 0.5), off = n();
        out.emplace_back(x + along * std::cos(heading) - off * std::sin(heading),
                         y + along * std::sin(heading) + off * std::cos(heading), -2.0 + (top + 2.0) * u());
        continue;
      }
      kind -= walls.size();
      if (kind < bushes.size()) {
        out.emplace_back(bushes[kind] + 20.0 * Vector3(n(), n(), n()));
        continue;
      }
      if (!has_ground) continue;
      const double r = 14.0 * std::sqrt(u()), a = 2.0 * M_PI * u();
      out.emplace_back(r * std::cos(a), r * std::sin(a), -2.0 + n());
    }
    return out;
  }
};

TEST(PlainFit, OfRandomPlacesIsTheSame) {
  int open = 0, held = 0, both = 0, nothing = 0;
  for (unsigned seed = 0; seed < 120; ++seed) {
    RandomPlace place(seed);
    SurfaceMapConfig map_config;
    map_config.points_per_cell = seed % 3 == 0 ? 60 : 300;
    SurfaceMap map(map_config);
    for (int i = 0; i < 3; ++i) map.insert(place.points(2500), Vector3(0.1, -0.2, 0.3));
    const Pose T = make_pose({0.04, -0.03, 0.02}, rotation_by({0.01, -0.02, 0.4 * seed}));
    const Pose T_scan = T * make_pose({0.02, 0.01, -0.02}, rotation_by({0.002, 0.001, 0.003}));
    std::vector<Eigen::Vector3f> points;
    for (const Vector3& p : place.points(500)) points.push_back((T_scan.inverse() * p).cast<float>());
    for (int i = 0; i < 20; ++i)
      points.emplace_back(30.0F + static_cast<float>(i), 4.0F, 2.0F);  // where nothing is known
    ScanToMapConfig config;
    config.standing_points = seed % 2 == 0 ? 10 : 3;
    config.degenerate_share = seed % 5 == 0 ? 0.02 : 0.003;
    config.point_weight = seed % 7 == 0 ? 0.0 : 0.02;
    config.kernel_sigma = 2.0 + seed % 3;
    config.reach_m = seed % 6 == 0 ? 0.05 : 0.5;
    config.surface_sigma_m = 0.01 + 0.01 * (seed % 2);
    const double smear_m = seed % 4 == 0 ? 0.05 : 0.0;
    const double range_sigma_m = 0.01 * (seed % 3);
    const ScanFit fit = fit_scan(map, points, T, config, smear_m, range_sigma_m);
    const ScanFit plain = plain_fit(map, points, T, config, smear_m, range_sigma_m);
    EXPECT_EQ(fit.num_points, plain.num_points);
    EXPECT_EQ(fit.num_known, plain.num_known) << seed;
    EXPECT_EQ(fit.num_fresh, plain.num_fresh) << seed;
    EXPECT_EQ(fit.num_planar, plain.num_planar) << seed;
    EXPECT_EQ(fit.num_near, plain.num_near) << seed;
    EXPECT_EQ(fit.num_held, plain.num_held) << seed;
    EXPECT_EQ(fit.num_degenerate, plain.num_degenerate) << seed;
    EXPECT_NEAR(fit.map_share, plain.map_share, 1e-8) << seed;
    EXPECT_NEAR(fit.renewal, plain.renewal, 1e-8) << seed;
    const double size = plain.evidence.information.norm();
    EXPECT_LE((fit.evidence.information - plain.evidence.information).norm(), 1e-8 * size) << seed;
    EXPECT_LE((fit.evidence.gradient - plain.evidence.gradient).norm(), 1e-8 * plain.evidence.gradient.norm()) << seed;
    open += plain.num_degenerate > 0 && plain.num_held == 0;
    held += plain.num_degenerate == 0 && plain.num_held > 0;
    both += plain.num_degenerate > 0 && plain.num_held > 0;
    nothing += plain.num_degenerate == 6;
  }
  EXPECT_GT(std::min({open, held, both}), 1) << open << " " << held << " " << both;
  EXPECT_GT(nothing, 0);
}

}  // namespace
}  // namespace swiftlet
