// SPDX-License-Identifier: BSD-3-Clause
#include "core/localization/teammate.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/messages/kind.hpp"

namespace swiftlet {
namespace {

// [-] Largest number of sightings queued until newer odometry arrives; beyond it the oldest is dropped. Smaller values
// lose sightings under long message delays.
constexpr std::size_t kMaxWaiting = 128;
/// [-] Results of the window in a row that contradict the filter until it is started again. Smaller values react to
/// outliers.
constexpr int kMaxDisagreements = 4;

Overlay overlay_of(const char* name, Overlay::Kind kind, float size_m, const char* meaning,
                   const Eigen::Vector4f& color) {
  Overlay overlay;
  overlay.name = name;
  overlay.kind = kind;
  overlay.size_m = size_m;
  overlay.colors = {color};
  overlay.legend = {{meaning, color}};
  return overlay;
}

}  // namespace

OtherMotion motion_of(const OdometryReport& report) {
  OtherMotion motion;
  motion.t = motion.stamp = report.t;
  motion.p_other_local_m = report.T_local_body.translation();
  motion.v_other_local_mps = report.v_local_mps;
  motion.yaw_rad = yaw_of(report.T_local_body.linear());
  motion.yaw_rate_radps = report.yaw_rate_radps;
  return motion;
}

bool OtherClock::take(TimeNs& stamp, TimeNs received) {
  if (one_way_ && count_ == 0) epoch_ = received - stamp;
  stamp += epoch_;
  const TimeNs delay = received - stamp;
  if (count_ > 0 && std::abs(delay - last_) > kClockJump) {
    count_ = 0;
    epoch_ = 0;
    return false;
  }
  last_ = delay;
  delays_s_[next_] = to_seconds(delay);
  next_ = (next_ + 1) % kNumDelays;
  count_ = std::min(count_ + 1, kNumDelays);
  return true;
}

ClockPrior OtherClock::prior() const {
  if (!one_way_ || count_ == 0) return {0.0, sigma_s_};
  return {*std::min_element(delays_s_.begin(), delays_s_.begin() + count_) - least_delay_s_, sigma_s_};
}

Teammate::Teammate(VehicleId id, const SlidingWindowConfig& config)
    : config_(config),
      id_(id),
      drift_(config.drift),
      clock_(config.clock, config.clock_sigma_s, config.least_delay_s),
      alignment_(config.alignment, config.drift),
      filter_(config.filter, config.drift) {}

bool Teammate::receive(std::span<const Message> messages) {
  bool has_report = false;
  for (const Message& message : messages) {
    OdometryReport report;
    if (message.from != id_ || read_message(message, report) != Reading::kDone) continue;
    ++num_reports_;
    OtherMotion motion = motion_of(report);
    if (!clock_.take(motion.t, message.received)) {
      start_over();
      continue;
    }
    if (!odometry_.push(motion)) continue;
    has_report = true;
    if (filter_.started()) num_late_ += !filter_.push(in_own_time(odometry_.newest()));
  }
  return has_report;
}

void Teammate::start_over() {
  odometry_ = {};
  alignment_.clear();
  filter_.stop();
  waiting_.clear();
  clock_s_.reset();
}

OtherMotion Teammate::in_own_time(OtherMotion motion) const {
  motion.t += from_seconds(clock_s());
  return motion;
}

bool Teammate::take(const Sighting& sighting) {
  if (!filter_.push(sighting)) return false;
  last_accepted_ = sighting.t;
  wait(sighting);
  return true;
}

void Teammate::mark_ambiguous(TimeNs t) {
  if (t - last_accepted_ <= from_seconds(config_.reacquire_s)) return;
  filter_.stop();
  ++num_lost_;
}

void Teammate::wait(const Sighting& sighting) {
  if (waiting_.size() == kMaxWaiting) waiting_.erase(waiting_.begin());
  waiting_.push_back(sighting);
  last_waiting_ = sighting.t;
}

void Teammate::wait_for_new_of(std::span<const Sighting> chain) {
  for (const Sighting& sighting : chain) {
    if (sighting.t > last_waiting_) wait(sighting);
  }
}

MotionMatch Teammate::match(std::span<const Sighting> chain) const {
  return match_motion(chain, odometry_, drift_, clock_s(), config_.odometry_gap_max_s);
}

void Teammate::update(bool has_report) {
  pair();
  if (has_report) align();
}

/// Pairs waiting sightings that the odometry has reached.
void Teammate::pair() {
  if (odometry_.empty()) return;
  const double clock_s_now = clock_s();
  const TimeNs clock = from_seconds(clock_s_now);
  std::erase_if(waiting_, [&](const Sighting& sighting) {
    if (sighting.t - clock > odometry_.newest().t) return false;
    const auto reported = odometry_.at(sighting.t - clock, config_.odometry_gap_max_s);
    if (!reported || sighting.t < last_pair_) return true;
    last_pair_ = sighting.t;
    const double sigma_m = config_.filter.odometry_sigma_m;
    alignment_.push({sighting.t, sighting.p_local_m, sighting.covariance + sigma_m * sigma_m * Matrix3::Identity(),
                     reported->p_other_local_m, reported->v_other_local_mps, clock_s_now, reported->flown});
    return true;
  });
}

void Teammate::align() {
  alignment_.set_drift_variance_factor(filter_.drift_variance_factor());
  const auto& found = alignment_.fit(odometry_.newest(), clock_.prior());
  if (!found) return;
  clock_s_ = found->clock_s;
  if (filter_.started() && agrees(*found)) return;
  filter_.start(*found, in_own_time(odometry_.newest()));
  ++num_starts_;
  num_disagreements_ = 0;
  last_accepted_ = in_own_time(odometry_.newest()).t;
  for (const Sighting& sighting : waiting_) filter_.push(sighting);
}

/// True while the filter agrees with the window, or deviates in fewer than kMaxDisagreements results in a row.
bool Teammate::agrees(const FrameAlignment& found) {
  const FrameAlignment own = filter_.alignment();
  Eigen::Matrix<double, 4, 1> difference;
  difference << found.point(own.anchor_other_m) - own.anchor_local_m,
      std::remainder(found.yaw_rad - own.yaw_rad, 2.0 * kPi);
  const FrameAlignment::Covariance S = own.covariance + found.covariance;
  const bool near = difference.dot(S.ldlt().solve(difference)) <= kDisagreement_sigma_sq;
  num_disagreements_ = near ? 0 : num_disagreements_ + 1;
  return num_disagreements_ < kMaxDisagreements;
}

std::optional<RelativeEstimate> Teammate::estimate(TimeNs t) {
  if (!filter_.started()) return std::nullopt;
  const RelativeEstimate estimate = filter_.at(t);
  if (!is_sure(estimate)) {
    filter_.stop();
    ++num_lost_;
    return std::nullopt;
  }
  last_ = estimate;
  last_.other = id_;
  return last_;
}

bool Teammate::is_sure(const RelativeEstimate& estimate) const {
  const Matrix3 C = estimate.covariance.topLeftCorner<3, 3>();
  const double greatest = Eigen::SelfAdjointEigenSolver<Matrix3>(C, Eigen::EigenvaluesOnly).eigenvalues()(2);
  return greatest <= config_.position_sigma_max_m * config_.position_sigma_max_m;
}

/// Estimated position and heading with three standard deviations, and the window's sightings beside the aligned
/// odometry.
void Teammate::append_overlays(std::vector<Overlay>& overlays) const {
  const Eigen::Vector4f kBlue = {0.0F, 0.45F, 0.7F, 0.45F}, kYellow = {0.94F, 0.89F, 0.26F, 1.0F};
  const char* const kMeaning = "teammate: heading and three standard deviations";
  Overlay place = overlay_of("relative", Overlay::Kind::kSpheres, 0.0F, kMeaning, kBlue);
  Overlay heading = overlay_of("relative", Overlay::Kind::kLines, 3.0F, kMeaning, kBlue);
  Overlay seen = overlay_of("relative.window", Overlay::Kind::kPoints, 0.05F, "sightings in the window", kBlue);
  Overlay reported = overlay_of("relative.window", Overlay::Kind::kPoints, 0.05F, "odometry, aligned", kYellow);
  for (const AlignmentPair& pair : alignment_.pairs()) seen.positions.push_back(pair.p_local_m.cast<float>());
  if (filter_.started()) {
    const Matrix3 C = last_.covariance.topLeftCorner<3, 3>();
    place.size_m = 3.0F * static_cast<float>(std::sqrt(C.trace() / 3.0));
    place.positions.push_back(last_.position_m.cast<float>());
    const Vector3 ahead(elementary::cos(last_.yaw_rad), elementary::sin(last_.yaw_rad), 0.0);
    heading.positions = {last_.position_m.cast<float>(), (last_.position_m + 0.5 * ahead).cast<float>()};
    const FrameAlignment alignment = filter_.alignment();
    for (const AlignmentPair& pair : alignment_.pairs()) {
      reported.positions.push_back(alignment.point(pair.p_other_m).cast<float>());
    }
  }
  for (Overlay* overlay : {&place, &heading, &seen, &reported}) overlays.push_back(std::move(*overlay));
}

}  // namespace swiftlet
