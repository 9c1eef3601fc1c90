// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/flocking/rbl_cell.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/guidance/guidance_constants.hpp"
#include "swiftlet/core/math/elementary_lanes.hpp"

namespace swiftlet {
namespace {

/// [-] Sum of weights below which the centroid is the sample nearest to the destination. Smaller values divide rounding
/// errors; larger ones make the centroid jump between samples.
constexpr double kUnderflow = 1e-30;
/// [m] Tolerance of the height limits: samples on a limit belong to the cell despite rounding.
constexpr float kSampleSlack_m = 1e-6F;
/// [-] Weight of a violated hard plane against a soft one when A is empty. Larger values give up soft planes sooner.
constexpr double kHard = 1e3;
/// [-] Weight of the distance from the agent against the violation: only breaks ties, in favor of the nearest sample.
constexpr double kTie = 1e-6;

/// Largest number of lattice points in a diameter, for any position of the lattice.
int most_in_a_row(double radius_m, double step_m) { return 2 * static_cast<int>(radius_m / step_m) + 2; }

/// Floor of a number not below -1. std::floor is a function call without SSE 4.1.
int floor_of(double value) { return static_cast<int>(value + 1.0) - 1; }
int ceil_of(double value) {
  const int below = floor_of(value);
  return below < value ? below + 1 : below;
}

/// 2^t for -126 <= t <= 0 in place, with a relative error of 2e-7. Without branches, so that the loop
/// vectorizes.
void raise_two(float* t, int count) {
  for (int i = 0; i < count; ++i) {
    const int whole = static_cast<int>(t[i] - 0.5F);
    const float x = 0.693147181F * (t[i] - static_cast<float>(whole));  // within half a step of 0
    const float power = 1.0F + x * (1.0F + x * (0.5F + x * (1.0F / 6 + x * (1.0F / 24 + x * (1.0F / 120 + x / 720)))));
    t[i] = power * std::bit_cast<float>((whole + 127) << 23);
  }
}

/// exp(-|q - d| / beta) for many q, relative to the largest possible one: far destinations and small beta do not
/// underflow.
template <class Samples>
void weigh(const Samples& x, const Samples& y, const Samples& z, const Vector3& destination_agent_m, double beta_m,
           double radius_m, Eigen::Ref<Eigen::ArrayXf> weight) {
  const Eigen::Vector3f d = destination_agent_m.cast<float>();
  const auto nearest = static_cast<float>(std::max(0.0, destination_agent_m.norm() - radius_m));
  const auto per_beta = static_cast<float>(std::numbers::log2e / beta_m);
  weight = (x - d.x()).square() + (y - d.y()).square() + (z - d.z()).square();
  take_roots({weight.data(), static_cast<std::size_t>(weight.size())});
  // The least exponent of a normal number: smaller weights are raised to it.
  weight = ((nearest - weight) * per_beta).max(static_cast<float>(std::numeric_limits<float>::min_exponent - 1));
  raise_two(weight.data(), static_cast<int>(weight.size()));
}

}  // namespace

RblCell::RblCell(double radius_m, double step_m, bool planar) : radius_m_(radius_m), step_m_(step_m), planar_(planar) {
  // The capacity suffices for every placement of the lattice: reset() never allocates.
  const int n = most_in_a_row(radius_m, step_m);
  const int layers = planar ? 1 : n;
  ball_.reserve(static_cast<std::size_t>(n) * layers);
  rows_.reserve(static_cast<std::size_t>(n) * layers);
  const Eigen::Index most = static_cast<Eigen::Index>(n) * n * layers;
  for (Eigen::ArrayXf* array : {&x_, &y_, &z_, &weight_, &in_x_, &in_y_, &in_z_}) array->setZero(most);
  sample_ball(Vector3::Zero());
  reset(Vector3::Zero(), -radius_m, radius_m);
}

void RblCell::reset(const Vector3& lattice_agent_m, double z_low_m, double z_high_m) {
  const auto phase = [&](double p) { return p - step_m_ * std::round(p / step_m_); };
  const Vector3 origin_agent_m(phase(lattice_agent_m.x()), phase(lattice_agent_m.y()),
                               planar_ ? 0.0 : phase(lattice_agent_m.z()));
  if (origin_agent_m != origin_m_) sample_ball(origin_agent_m);
  auto low = ball_.cbegin(), high = ball_.cend();
  if (!planar_) {
    low = std::partition_point(low, high, [&](const Row& row) { return row.z < z_low_m - kSampleSlack_m; });
    high = std::partition_point(low, high, [&](const Row& row) { return row.z <= z_high_m + kSampleSlack_m; });
  }
  rows_.assign(low, high);
  first_sample_ = rows_.empty() ? 0 : rows_.front().first;
  num_samples_ = rows_.empty() ? 0 : rows_.back().first + rows_.back().count - first_sample_;
  high_m_ = Vector3::Constant(radius_m_);
  low_m_ = -high_m_;
}

void RblCell::sample_ball(const Vector3& origin_agent_m) {
  origin_m_ = origin_agent_m;
  ball_.clear();
  int num_samples = 0;
  const double slack_m = kNegligible * radius_m_;  // samples on the sphere belong to the ball despite rounding
  const auto first_index = [&](double low, double from) {
    return static_cast<int>(std::ceil((low - slack_m - from) / step_m_));
  };
  const auto last_index = [&](double high, double from) {
    return static_cast<int>(std::floor((high + slack_m - from) / step_m_));
  };
  const int k_low = planar_ ? 0 : first_index(-radius_m_, origin_agent_m.z());
  const int k_high = planar_ ? 0 : last_index(radius_m_, origin_agent_m.z());
  for (int k = k_low; k <= k_high; ++k) {
    const double z = origin_agent_m.z() + k * step_m_;
    const double disc_sq = std::max(0.0, radius_m_ * radius_m_ - z * z);
    const double disc = std::sqrt(disc_sq);
    for (int j = first_index(-disc, origin_agent_m.y()); j <= last_index(disc, origin_agent_m.y()); ++j) {
      const double y = origin_agent_m.y() + j * step_m_;
      const double half = std::sqrt(std::max(0.0, disc_sq - y * y));
      const int i_low = first_index(-half, origin_agent_m.x());
      const int count = last_index(half, origin_agent_m.x()) - i_low + 1;
      if (count <= 0) continue;
      const double x0 = origin_agent_m.x() + i_low * step_m_;
      for (int i = 0; i < count; ++i) x_[num_samples + i] = static_cast<float>(x0 + i * step_m_);
      y_.segment(num_samples, count).setConstant(static_cast<float>(y));
      z_.segment(num_samples, count).setConstant(static_cast<float>(z));
      ball_.push_back({num_samples, count, 0, count, static_cast<float>(x0), static_cast<float>(y),
                       static_cast<float>(z), static_cast<float>(x0 / step_m_)});
      num_samples += count;
    }
  }
}

void RblCell::cut(const HalfSpace& keep) {
  if (keep.offset_m >= radius_m_) return;  // S lies within the half-space
  const Vector3& n = keep.normal_local;
  const double farthest_m = (n.cwiseProduct(low_m_)).cwiseMax(n.cwiseProduct(high_m_)).sum();
  if (farthest_m <= keep.offset_m - kPlaneSlack_m) return;  // A lies within the half-space
  const double nx = n.x();
  const double per_step = 1.0 / (nx * step_m_);
  const bool level = std::abs(nx) < kNegligible;
  Eigen::Array3f low = Eigen::Array3f::Constant(std::numeric_limits<float>::infinity()), high = -low;
  for (Row& row : rows_) {
    if (row.low == row.high) continue;
    const double rest = keep.offset_m - n.y() * row.y - n.z() * row.z;  // nx * x <= rest
    if (level) {
      if (rest < 0.0) row.high = row.low;
    } else {
      const double i_plane = std::clamp(rest * per_step - row.x0_steps, -1.0, row.count + 1.0);
      if (nx > 0.0) {
        row.high = std::max(row.low, std::min(row.high, floor_of(i_plane) + 1));
      } else {
        row.low = std::min(row.high, std::max(row.low, ceil_of(i_plane)));
      }
    }
    if (row.low == row.high) continue;
    low = low.min(Eigen::Array3f(row.x0_steps + static_cast<float>(row.low), row.y, row.z));
    high = high.max(Eigen::Array3f(row.x0_steps + static_cast<float>(row.high), row.y, row.z));
  }
  low_m_ = Vector3(step_m_ * low.x(), low.y(), low.z());
  high_m_ = Vector3(step_m_ * high.x(), high.y(), high.z());
}

bool RblCell::contains(int sample) const {
  const int i = first_sample_ + sample;
  const auto after =
      std::upper_bound(rows_.begin(), rows_.end(), i, [](int s, const Row& row) { return s < row.first; });
  const Row& row = *(after - 1);
  return i - row.first >= row.low && i - row.first < row.high;
}

int RblCell::num_partitioned() const {
  int count = 0;
  for (const Row& row : rows_) count += row.high - row.low;
  return count;
}

bool RblCell::is_empty() const { return num_partitioned() == 0; }

Vector3 RblCell::centroid(const Sums& sums, const Vector3& destination_agent_m) const {
  if (sums.weight > kUnderflow) return sums.moment_agent / sums.weight;
  // All weights underflowed, or A is empty. For beta toward 0, the centroid converges to the sample nearest to the
  // destination.
  const int sample = nearest_partitioned(destination_agent_m);
  return sample < 0 ? Vector3(Vector3::Zero()) : point(sample);
}

CellCentroids RblCell::centroids(const Vector3& destination_agent_m, double beta_m) {
  weigh(x_.segment(first_sample_, num_samples_), y_.segment(first_sample_, num_samples_),
        z_.segment(first_sample_, num_samples_), destination_agent_m, beta_m, radius_m_,
        weight_.segment(first_sample_, num_samples_));
  // y and z are constant in a row.
  const auto add = [](Sums& sums, const Row& row, float weight, float moment_x) {
    sums.weight += weight;
    sums.moment_agent += Vector3(moment_x, weight * row.y, weight * row.z);
  };
  Sums sensing, partitioned;
  for (const Row& row : rows_) {
    const auto weight = weight_.segment(row.first, row.count);
    const auto x = x_.segment(row.first, row.count);
    const float sum = weight.sum(), sum_x = (weight * x).sum();
    add(sensing, row, sum, sum_x);
    const int count = row.high - row.low;
    if (count == 0) continue;
    if (count == row.count) {
      add(partitioned, row, sum, sum_x);
    } else {
      const auto in = weight.segment(row.low, count);
      add(partitioned, row, in.sum(), (in * x.segment(row.low, count)).sum());
    }
  }
  CellCentroids result;
  result.partitioned_agent_m = centroid(partitioned, destination_agent_m);
  result.sensing_agent_m =
      sensing.weight > 0.0 ? Vector3(sensing.moment_agent / sensing.weight) : Vector3(Vector3::Zero());
  return result;
}

Vector3 RblCell::partitioned_centroid(const Vector3& destination_agent_m, double beta_m) {
  int count = 0;
  for (const Row& row : rows_) {
    for (int i = row.first + row.low; i < row.first + row.high; ++i) {
      in_x_[count] = x_[i];
      in_y_[count] = row.y;
      in_z_[count++] = row.z;
    }
  }
  const auto weight = weight_.head(count);
  weigh(in_x_.head(count), in_y_.head(count), in_z_.head(count), destination_agent_m, beta_m, radius_m_,
        weight_.head(count));
  Sums sums;
  sums.weight = weight.sum();
  sums.moment_agent = Vector3((weight * in_x_.head(count)).sum(), (weight * in_y_.head(count)).sum(),
                              (weight * in_z_.head(count)).sum());
  return centroid(sums, destination_agent_m);
}

int RblCell::nearest_partitioned(const Vector3& wanted_agent_m) const {
  int best = -1;
  double best_sq = std::numeric_limits<double>::infinity();
  for (const Row& row : rows_) {
    for (int i = row.first + row.low; i < row.first + row.high; ++i) {
      const double distance_sq = (at(i) - wanted_agent_m).squaredNorm();
      if (distance_sq >= best_sq) continue;
      best_sq = distance_sq;
      best = i - first_sample_;
    }
  }
  return best;
}

Vector3 RblCell::least_violating(const std::vector<HalfSpace>& cuts, std::size_t num_soft) const {
  Vector3 best = Vector3::Zero();
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < num_samples_; ++i) {
    const Vector3 q = point(i);
    double worst = 0.0;
    for (std::size_t k = 0; k < cuts.size(); ++k) {
      const double beyond_m = cuts[k].normal_local.dot(q) - cuts[k].offset_m;
      worst = std::max(worst, k < num_soft ? beyond_m : kHard * beyond_m);
    }
    const double cost = worst + kTie * q.norm();
    if (cost >= least) continue;
    least = cost;
    best = q;
  }
  return best;
}

}  // namespace swiftlet
