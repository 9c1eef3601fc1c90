// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/localization/relative_localizer.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "swiftlet/core/localization/frame_change.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/core/messages/odometry_report.hpp"
#include "swiftlet/core/vehicle_named.hpp"

namespace swiftlet {
namespace {

constexpr TimeNs kClockJump = 5 * kNsPerSecond;  // nobody's clock drifts so much from message to message
constexpr std::size_t kMaxWaiting = 128;
constexpr int kMaxDisagreements = 4;
constexpr double kDisagreement_sigma_sq = 30.0;  // 1 in 200 000 by chance, with four degrees of freedom

OtherMotion motion_of(const OdometryReport& report) {
  OtherMotion motion;
  motion.t = motion.stamp = report.t;
  motion.p_other_local_m = report.T_local_body.translation();
  motion.v_other_local_mps = report.v_local_mps;
  motion.yaw_rad = yaw_of(report.T_local_body.linear());
  motion.yaw_rate_radps = report.yaw_rate_radps;
  return motion;
}

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

/// How far another clock is behind, from what came: a message takes some time, the quickest one nearly none.
class OtherClock {
 public:
  OtherClock(SlidingWindowConfig::Clock mode, double sigma_s, double least_delay_s)
      : one_way_(mode == SlidingWindowConfig::Clock::kOneWay), sigma_s_(sigma_s), least_delay_s_(least_delay_s) {}

  /// The stamp in a time that is the own one but for a little. False: the clock has jumped since the last one.
  bool take(TimeNs& stamp, TimeNs received) {
    if (one_way_ && count_ == 0) epoch_ = received - stamp;
    stamp += epoch_;
    const TimeNs took = received - stamp;
    if (count_ > 0 && std::abs(took - last_) > kClockJump) {
      count_ = 0;
      epoch_ = 0;
      return false;
    }
    last_ = took;
    took_s_[next_] = to_seconds(took);
    next_ = (next_ + 1) % kRemembered;
    count_ = std::min(count_ + 1, kRemembered);
    return true;
  }
  ClockPrior prior() const {
    if (!one_way_ || count_ == 0) return {0.0, sigma_s_};
    return {*std::min_element(took_s_.begin(), took_s_.begin() + count_) - least_delay_s_, sigma_s_};
  }

 private:
  static constexpr int kRemembered = 64;  // half a minute: a clock that drifts moves little
  bool one_way_;
  double sigma_s_, least_delay_s_;
  TimeNs epoch_ = 0, last_ = 0;
  std::array<double, kRemembered> took_s_{};
  int next_ = 0, count_ = 0;
};

class SlidingWindow : public RelativeLocalizer {
 public:
  SlidingWindow(const SlidingWindowConfig& config, const AgentSetup& setup)
      : config_(config),
        other_(vehicle_named(config.other, setup, "relative_localization.other")),
        clock_(config.clock, config.clock_sigma_s, config.least_delay_s),
        alignment_(config.alignment, config.drift),
        filter_(config.filter, config.drift) {}

  void step(const RelativeInput& input, std::vector<RelativeEstimate>& relatives, Outbox&) override {
    const bool heard = hear(input.observation.messages);
    see(input);
    pair();
    if (heard) align();
    if (!filter_.started()) return;
    const RelativeEstimate estimate = filter_.at(input.observation.t);
    if (!is_sure(estimate)) {
      filter_.stop();
      ++num_lost_;
      return;
    }
    last_ = estimate;
    last_.other = other_;
    relatives.push_back(last_);
  }

  /// Where it is and heads, with three standard deviations, and the sightings of the window beside the aligned
  /// odometry.
  void append_overlays(std::vector<Overlay>& overlays) const override {
    const Eigen::Vector4f kGreen = {0.2F, 0.9F, 0.3F, 0.35F}, kWhite = {0.95F, 0.95F, 0.95F, 1.0F};
    Overlay place =
        overlay_of("relative", Overlay::Kind::kSpheres, 0.0F, "teammate: three standard deviations", kGreen);
    Overlay heading = overlay_of("relative", Overlay::Kind::kLines, 3.0F, "teammate: heading", kGreen);
    Overlay seen = overlay_of("relative.window", Overlay::Kind::kPoints, 0.05F, "sightings in the window", kGreen);
    Overlay told = overlay_of("relative.window", Overlay::Kind::kPoints, 0.05F, "odometry, aligned", kWhite);
    for (const AlignmentPair& pair : alignment_.pairs()) seen.positions.push_back(pair.p_local_m.cast<float>());
    if (filter_.started()) {
      const Matrix3 C = last_.covariance.topLeftCorner<3, 3>();
      place.size_m = 3.0F * static_cast<float>(std::sqrt(C.trace() / 3.0));
      place.positions.push_back(last_.position_m.cast<float>());
      const Vector3 ahead(elementary::cos(last_.yaw_rad), elementary::sin(last_.yaw_rad), 0.0);
      heading.positions = {last_.position_m.cast<float>(), (last_.position_m + 0.5 * ahead).cast<float>()};
      const FrameAlignment alignment = filter_.alignment();
      for (const AlignmentPair& pair : alignment_.pairs()) {
        told.positions.push_back(alignment.point(pair.p_other_m).cast<float>());
      }
    }
    for (Overlay* overlay : {&place, &heading, &seen, &told}) overlays.push_back(std::move(*overlay));
  }

  void append_counters(std::vector<Counter>& counters) const override {
    counters.push_back(
        {"sightings that were not the guided vehicle's", num_rejected_, num_sightings_, "marker_reflectivity"});
    counters.push_back(
        {"sightings or odometry too late", num_late_, num_sightings_ + num_reports_, "filter.history_s"});
    counters.push_back({"losses of the guided vehicle", num_lost_, std::max<std::uint64_t>(num_starts_, num_lost_),
                        "position_sigma_max_m"});
  }

 private:
  struct MarkedTrack {
    std::uint32_t id;
    TimeNs bright;  // when it was last
  };

  // ---- what it tells
  bool hear(std::span<const Message> messages) {
    bool heard = false;
    for (const Message& message : messages) {
      OdometryReport report;
      if (message.from != other_ || read_message(message, report) != Reading::kDone) continue;
      ++num_reports_;
      OtherMotion motion = motion_of(report);
      if (!clock_.take(motion.t, message.received)) {
        start_over();
        continue;
      }
      if (!odometry_.push(motion)) continue;
      heard = true;
      if (filter_.started()) num_late_ += !filter_.push(in_own_time(odometry_.newest()));
    }
    return heard;
  }

  void start_over() {
    odometry_ = {};
    alignment_.clear();
    filter_.stop();
    waiting_.clear();
    clock_s_.reset();
  }

  double clock_s() const { return clock_s_ ? *clock_s_ : clock_.prior().clock_s; }
  OtherMotion in_own_time(OtherMotion motion) const {
    motion.t += from_seconds(clock_s());
    return motion;
  }

  // ---- where it is seen
  void see(const RelativeInput& input) {
    seen_.clear();
    if (config_.source == SlidingWindowConfig::Source::kDetections) {
      for (const Detection& d : input.detections) {
        if (d.reflectivity >= config_.marker_reflectivity) take_in(d.t, d.position_m, d.covariance, input.poses);
      }
    } else if (input.has_tracks) {
      for (const Track& track : input.tracks) {
        if (track.corrected && is_marked(track)) {
          take_in(track.t, track.measured_m, track.measured_covariance, input.poses);
        }
      }
    }
    if (!filter_.started()) {
      for (const Sighting& sighting : seen_) wait(sighting);
      return;
    }
    // Of those that are no other thing's, the nearest.
    const auto nearest = std::min_element(seen_.begin(), seen_.end(), [this](const Sighting& a, const Sighting& b) {
      return filter_.squared_sigmas(a) < filter_.squared_sigmas(b);
    });
    if (nearest == seen_.end()) return;
    num_rejected_ += seen_.size();
    if (!filter_.push(*nearest)) {
      // Whatever it is that is seen instead for so long may be it.
      if (nearest->t - last_accepted_ > from_seconds(config_.reacquire_s)) {
        filter_.stop();
        ++num_lost_;
      }
      return;
    }
    --num_rejected_;
    last_accepted_ = nearest->t;
    wait(*nearest);
  }

  /// A track that was bright a moment ago: far away, few beams meet a marker.
  bool is_marked(const Track& track) {
    if (config_.marker_reflectivity <= 0.0) return true;
    const TimeNs memory = from_seconds(config_.marker_memory_s);
    std::erase_if(marked_, [&](const MarkedTrack& m) { return track.t - m.bright > memory; });
    const auto known =
        std::find_if(marked_.begin(), marked_.end(), [&](const MarkedTrack& m) { return m.id == track.id; });
    if (track.reflectivity < config_.marker_reflectivity) return known != marked_.end();
    if (known == marked_.end())
      marked_.push_back({track.id, track.t});
    else
      known->bright = track.t;
    return true;
  }

  void take_in(TimeNs t, const Vector3& p_local_m, const Matrix3& covariance, const LocalPoses& poses) {
    ++num_sightings_;
    const Vector3 ray_m = p_local_m - poses.at(t).translation();
    const Vector3 behind_m = ray_m.norm() > 0.0 ? Vector3(config_.center_behind_m * ray_m.normalized()) : ray_m;
    seen_.push_back({t, p_local_m + behind_m + config_.center_above_m * Vector3::UnitZ(), covariance});
  }

  void wait(const Sighting& sighting) {
    if (waiting_.size() == kMaxWaiting) waiting_.erase(waiting_.begin());
    waiting_.push_back(sighting);
  }

  // ---- both together
  /// Sightings that the odometry has come up to.
  void pair() {
    if (odometry_.empty()) return;
    const double clock_s_now = clock_s();
    const TimeNs clock = from_seconds(clock_s_now);
    std::erase_if(waiting_, [&](const Sighting& sighting) {
      if (sighting.t - clock > odometry_.newest().t) return false;
      const auto told = odometry_.at(sighting.t - clock, config_.odometry_gap_max_s);
      if (!told || sighting.t < last_pair_) return true;
      last_pair_ = sighting.t;
      const double sigma_m = config_.filter.odometry_sigma_m;
      alignment_.push({sighting.t, sighting.p_local_m, sighting.covariance + sigma_m * sigma_m * Matrix3::Identity(),
                       told->p_other_local_m, told->v_other_local_mps, clock_s_now, told->flown});
      return true;
    });
  }

  void align() {
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

  /// The filter is what the window says, or off by chance for a moment.
  bool agrees(const FrameAlignment& found) {
    const FrameAlignment own = filter_.alignment();
    Eigen::Matrix<double, 4, 1> difference;
    difference << found.point(own.anchor_other_m) - own.anchor_local_m,
        std::remainder(found.yaw_rad - own.yaw_rad, 2.0 * kPi);
    const FrameAlignment::Covariance S = own.covariance + found.covariance;
    const bool near = difference.dot(S.ldlt().solve(difference)) <= kDisagreement_sigma_sq;
    num_disagreements_ = near ? 0 : num_disagreements_ + 1;
    return num_disagreements_ < kMaxDisagreements;
  }

  bool is_sure(const RelativeEstimate& estimate) const {
    const Matrix3 C = estimate.covariance.topLeftCorner<3, 3>();
    const double greatest = Eigen::SelfAdjointEigenSolver<Matrix3>(C, Eigen::EigenvaluesOnly).eigenvalues()(2);
    return greatest <= config_.position_sigma_max_m * config_.position_sigma_max_m;
  }

  SlidingWindowConfig config_;
  VehicleId other_;
  OtherClock clock_;
  std::optional<double> clock_s_;  // found with the alignment
  RelativeOdometry odometry_;      // by the other clock, near the own one
  RelativeAlignment alignment_;
  RelativeFilter filter_;
  RelativeEstimate last_;  // for pictures
  std::vector<MarkedTrack> marked_;
  std::vector<Sighting> seen_;     // in this tick
  std::vector<Sighting> waiting_;  // for odometry that is newer
  TimeNs last_pair_ = 0, last_accepted_ = 0;
  int num_disagreements_ = 0;
  std::uint64_t num_reports_ = 0, num_sightings_ = 0, num_rejected_ = 0, num_late_ = 0;
  std::uint64_t num_starts_ = 0, num_lost_ = 0;
};

class SharedWorld : public RelativeLocalizer {
 public:
  SharedWorld(const SharedWorldConfig& config, const AgentSetup& setup)
      : config_(config), other_(vehicle_named(config.other, setup, "relative_localization.other")) {}

  void step(const RelativeInput& input, std::vector<RelativeEstimate>& relatives, Outbox&) override {
    for (const Message& message : input.observation.messages) {
      OdometryReport report;
      if (message.from == other_ && read_message(message, report) == Reading::kDone) newest_ = motion_of(report);
    }
    const TimeNs t = input.observation.t;
    if (!newest_ || t - newest_->t > from_seconds(config_.timeout_s)) return;
    const double since_s = to_seconds(t - newest_->t);
    RelativeEstimate told;
    told.t = t;
    told.other = other_;
    told.position_m = newest_->p_other_local_m + since_s * newest_->v_other_local_mps;
    told.velocity_mps = newest_->v_other_local_mps;
    told.yaw_rad = std::remainder(newest_->yaw_rad + since_s * newest_->yaw_rate_radps, 2.0 * kPi);
    const double sigma_rad = config_.yaw_sigma_deg * kRadPerDeg;
    told.covariance.setZero();
    told.covariance.diagonal() << Vector3::Constant(config_.sigma_m * config_.sigma_m),
        Vector3::Constant(config_.sigma_m * config_.sigma_m), sigma_rad * sigma_rad;
    told.seen = told.heard = newest_->t;
    told.heard_stamp = newest_->stamp;
    told.heard_position_m = newest_->p_other_local_m;
    told.heard_yaw_rad = newest_->yaw_rad;
    relatives.push_back(FrameChange::to_local(input.estimate).relative(told));
  }

 private:
  SharedWorldConfig config_;
  VehicleId other_;
  std::optional<OtherMotion> newest_;  // in the world
};

}  // namespace

void SlidingWindowConfig::visit(ConfigVisitor& v) {
  v.field("other", other,
          "[-] name of the vehicle to localize, which tells its odometry (follow_guide); empty: the first other one");
  v.choice("source", source, {"detections", "tracks"},
           "[-] what is taken as sightings: detections, or the clusters on which tracks were corrected");
  v.field("marker_reflectivity", marker_reflectivity,
          "[-] a sighting is of the other's markers when its brightest return reflects this much (1: white Lambertian, "
          "retro-reflectors 10 and more); 0: it has none, all sightings count",
          Range::non_negative());
  v.field("marker_memory_s", marker_memory_s,
          "[s] with tracks: so long after its last bright return a track is still taken for the other's",
          Range::non_negative());
  v.field("center_behind_m", center_behind_m,
          "[m] the center of the other lies so far behind the middle of its returns: only its near side is seen",
          Range::between(-1.0, 1.0));
  v.field("center_above_m", center_above_m, "[m] and so far above it", Range::between(-1.0, 1.0));
  v.choice("clock", clock, {"synchronized", "one_way"},
           "[-] the other's clock: the own one (NTP), or any, found by its quickest message");
  v.field("clock_sigma_s", clock_sigma_s,
          "[s] how well its clock is known by that; the alignment finds the rest. 0: exactly",
          Range::between(0.0, 10.0));
  v.field("least_delay_s", least_delay_s, "[s] with one_way: what the quickest message takes",
          Range::between(0.0, 10.0));
  v.field("odometry_gap_max_s", odometry_gap_max_s, "[s] sightings in a longer gap of its odometry are not paired",
          Range::positive());
  v.field("position_sigma_max_m", position_sigma_max_m,
          "[m] greatest standard deviation of its position beyond which it counts as lost", Range::positive());
  v.field("reacquire_s", reacquire_s,
          "[s] of bright sightings elsewhere, and none where it is expected, after which it counts as lost",
          Range::positive());
  v.object("alignment", alignment, "sliding window that finds where its local frame lies");
  v.object("filter", filter, "Kalman filter of its position, velocity and alignment");
  v.object("drift", drift, "what its odometry may drift");
}

void SharedWorldConfig::visit(ConfigVisitor& v) {
  v.field("other", other,
          "[-] name of the vehicle to localize, which tells its odometry and started from a known pose; empty: the "
          "first other one");
  v.field("sigma_m", sigma_m, "[m] standard deviation of its position, by axis", Range::positive());
  v.field("yaw_sigma_deg", yaw_sigma_deg, "[deg] and of its heading", Range::positive());
  v.field("timeout_s", timeout_s, "[s] without a message, after which it is not known where it is", Range::positive());
}

std::unique_ptr<RelativeLocalizer> make_no_relative_localizer(const ModuleConfig&, const AgentSetup&) {
  return nullptr;
}

std::unique_ptr<RelativeLocalizer> make_sliding_window_localizer(const ModuleConfig& config, const AgentSetup& setup) {
  return std::make_unique<SlidingWindow>(dynamic_cast<const SlidingWindowConfig&>(config), setup);
}

std::unique_ptr<RelativeLocalizer> make_shared_world_localizer(const ModuleConfig& config, const AgentSetup& setup) {
  return std::make_unique<SharedWorld>(dynamic_cast<const SharedWorldConfig&>(config), setup);
}

}  // namespace swiftlet
