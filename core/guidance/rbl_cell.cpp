// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/rbl_cell.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace swiftlet {
namespace {

constexpr double kUnderflow = 1e-30;  // a sum of weights below this is rounding
constexpr int kChunk = 1024;          // samples weighted at a time: they stay in the first-level cache

int most_in_a_row(double radius_m, double step_m) { return 2 * static_cast<int>(radius_m / step_m) + 2; }

}  // namespace

RblCell::RblCell(double radius_m, double step_m, bool planar) : radius_m_(radius_m), step_m_(step_m), planar_(planar) {
  // The bound holds for every placement of the lattice: reset() never allocates.
  const int n = most_in_a_row(radius_m, step_m);
  const int layers = planar ? 1 : n;
  rows_.reserve(static_cast<std::size_t>(n) * layers);
  const Eigen::Index most = static_cast<Eigen::Index>(n) * n * layers;
  for (Eigen::ArrayXf* array : {&x_, &y_, &z_, &inside_}) array->setZero(most);
  reset(Vector3::Zero(), -radius_m, radius_m);
}

void RblCell::reset(const Vector3& lattice_m, double z_low_m, double z_high_m) {
  rows_.clear();
  num_samples_ = 0;
  masked_ = excluded_ = false;
  const auto phase = [&](double p) { return p - step_m_ * std::round(p / step_m_); };
  const Vector3 origin(phase(lattice_m.x()), phase(lattice_m.y()), planar_ ? 0.0 : phase(lattice_m.z()));
  const double slack_m = 1e-9 * radius_m_;  // samples on the sphere count
  const auto first_index = [&](double low, double at) {
    return static_cast<int>(std::ceil((low - slack_m - at) / step_m_));
  };
  const auto last_index = [&](double high, double at) {
    return static_cast<int>(std::floor((high + slack_m - at) / step_m_));
  };

  const int k_low = planar_ ? 0 : first_index(std::max(z_low_m, -radius_m_), origin.z());
  const int k_high = planar_ ? 0 : last_index(std::min(z_high_m, radius_m_), origin.z());
  for (int k = k_low; k <= k_high; ++k) {
    const double z = origin.z() + k * step_m_;
    const double disc_sq = std::max(0.0, radius_m_ * radius_m_ - z * z);
    const double disc = std::sqrt(disc_sq);
    for (int j = first_index(-disc, origin.y()); j <= last_index(disc, origin.y()); ++j) {
      const double y = origin.y() + j * step_m_;
      const double half = std::sqrt(std::max(0.0, disc_sq - y * y));
      const int i_low = first_index(-half, origin.x());
      const int count = last_index(half, origin.x()) - i_low + 1;
      if (count <= 0) continue;
      const double x0 = origin.x() + i_low * step_m_;
      for (int i = 0; i < count; ++i) x_[num_samples_ + i] = static_cast<float>(x0 + i * step_m_);
      y_.segment(num_samples_, count).setConstant(static_cast<float>(y));
      z_.segment(num_samples_, count).setConstant(static_cast<float>(z));
      rows_.push_back(
          {num_samples_, 0, count, static_cast<float>(x0), static_cast<float>(y), static_cast<float>(z), count});
      num_samples_ += count;
    }
  }
}

void RblCell::cut(const HalfSpace& keep) {
  const double nx = keep.normal.x();
  const double per_step = 1.0 / (nx * step_m_);
  for (Row& row : rows_) {
    const double rest = keep.offset_m - keep.normal.y() * row.y - keep.normal.z() * row.z;  // nx * x <= rest
    if (std::abs(nx) < 1e-9) {
      if (rest < 0.0) row.high = row.low;
      continue;
    }
    const double i_plane = std::clamp(rest * per_step - row.x0 / step_m_, -1.0, row.row_count + 1.0);
    if (nx > 0.0) {
      row.high = std::min(row.high, static_cast<int>(std::floor(i_plane)) + 1);
    } else {
      row.low = std::min(row.high, std::max(row.low, static_cast<int>(std::ceil(i_plane))));
    }
    row.high = std::max(row.high, row.low);
  }
  trim();
}

void RblCell::cut_ball(const Vector3& center_m, double radius_m) {
  for (Row& row : rows_) {
    const double dy = row.y - center_m.y(), dz = row.z - center_m.z();
    const double half_sq = radius_m * radius_m - dy * dy - dz * dz;
    if (half_sq < 0.0) {
      row.high = row.low;
      continue;
    }
    const double half = std::sqrt(half_sq);
    const double limit = row.row_count + 1.0;
    const double i_low = std::clamp((center_m.x() - half - row.x0) / step_m_, -1.0, limit);
    const double i_high = std::clamp((center_m.x() + half - row.x0) / step_m_, -1.0, limit);
    row.low = std::min(row.high, std::max(row.low, static_cast<int>(std::ceil(i_low))));
    row.high = std::max(row.low, std::min(row.high, static_cast<int>(std::floor(i_high)) + 1));
  }
  trim();
}

// After the intervals have shrunk: the mask follows, or is made anew when it is needed.
void RblCell::trim() {
  if (!excluded_) {
    masked_ = false;
    return;
  }
  for (const Row& row : rows_) {
    inside_.segment(row.first, row.low).setZero();
    inside_.segment(row.first + row.high, row.row_count - row.high).setZero();
  }
}

void RblCell::prepare_mask() {
  if (masked_) return;
  masked_ = true;
  inside_.head(num_samples_).setZero();
  for (const Row& row : rows_) inside_.segment(row.first + row.low, row.high - row.low).setOnes();
}

bool RblCell::contains(int sample) const {
  if (excluded_) return inside_[sample] != 0.0F;
  const auto after =
      std::upper_bound(rows_.begin(), rows_.end(), sample, [](int s, const Row& row) { return s < row.first; });
  const Row& row = *(after - 1);
  return sample - row.first >= row.low && sample - row.first < row.high;
}

int RblCell::num_partitioned() const {
  if (excluded_) return static_cast<int>(inside_.head(num_samples_).sum());
  int count = 0;
  for (const Row& row : rows_) count += row.high - row.low;
  return count;
}

bool RblCell::is_empty() const { return num_partitioned() == 0; }

void RblCell::add_weighted(const Vector3& destination_m, double beta_m, Sums* sensing, Sums& partitioned) {
  prepare_mask();
  const Eigen::Vector3f d = destination_m.cast<float>();
  // Weights relative to the largest possible one: far destinations and small beta do not underflow.
  const auto nearest = static_cast<float>(std::max(0.0, destination_m.norm() - radius_m_));
  const auto per_beta = static_cast<float>(1.0 / beta_m);
  Eigen::Array<float, Eigen::Dynamic, 1, 0, kChunk, 1> weight;
  const auto add = [&](Sums& sums, int first, int count) {
    sums.weight += weight.sum();
    sums.moment.x() += (weight * x_.segment(first, count)).sum();
    sums.moment.y() += (weight * y_.segment(first, count)).sum();
    sums.moment.z() += (weight * z_.segment(first, count)).sum();
  };
  for (int first = 0; first < num_samples_; first += kChunk) {
    const int count = std::min(kChunk, num_samples_ - first);
    weight = ((x_.segment(first, count) - d.x()).square() + (y_.segment(first, count) - d.y()).square() +
              (z_.segment(first, count) - d.z()).square())
                 .sqrt();
    weight = ((nearest - weight) * per_beta).exp();
    if (sensing != nullptr) add(*sensing, first, count);
    weight *= inside_.segment(first, count);
    add(partitioned, first, count);
  }
}

Vector3 RblCell::centroid(const Sums& sums, const Vector3& destination_m) const {
  if (sums.weight > kUnderflow) return sums.moment / sums.weight;
  // Every weight underflowed (or there is no sample): what a vanishing beta tends to.
  const int sample = nearest_partitioned(destination_m);
  return sample < 0 ? Vector3(Vector3::Zero()) : point(sample);
}

CellCentroids RblCell::centroids(const Vector3& destination_m, double beta_m) {
  Sums sensing, partitioned;
  add_weighted(destination_m, beta_m, &sensing, partitioned);
  CellCentroids result;
  result.partitioned_m = centroid(partitioned, destination_m);
  result.sensing_m = sensing.weight > 0.0 ? Vector3(sensing.moment / sensing.weight) : Vector3(Vector3::Zero());
  return result;
}

Vector3 RblCell::partitioned_centroid(const Vector3& destination_m, double beta_m) {
  Sums partitioned;
  add_weighted(destination_m, beta_m, nullptr, partitioned);
  return centroid(partitioned, destination_m);
}

int RblCell::nearest_partitioned(const Vector3& to_m) const {
  int best = -1;
  double best_sq = std::numeric_limits<double>::infinity();
  for (const Row& row : rows_) {
    for (int i = row.first + row.low; i < row.first + row.high; ++i) {
      if (excluded_ && inside_[i] == 0.0F) continue;
      const double distance_sq = (point(i) - to_m).squaredNorm();
      if (distance_sq >= best_sq) continue;
      best_sq = distance_sq;
      best = i;
    }
  }
  return best;
}

Vector3 RblCell::least_violating(const std::vector<HalfSpace>& cuts) const {
  Vector3 best = Vector3::Zero();
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < num_samples_; ++i) {
    const Vector3 q = point(i);
    double worst = 0.0;
    for (const HalfSpace& cut : cuts) worst = std::max(worst, cut.normal.dot(q) - cut.offset_m);
    // Of equal ones the nearest.
    const double cost = worst + 1e-6 * q.norm();
    if (cost >= least) continue;
    least = cost;
    best = q;
  }
  return best;
}

}  // namespace swiftlet
