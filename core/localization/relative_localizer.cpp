// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/localization/relative_localizer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/localization/marker_sightings.hpp"
#include "core/localization/teammate.hpp"
#include "swiftlet/core/base/vehicle_named.hpp"
#include "swiftlet/core/localization/frame_change.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/core/messages/odometry_report.hpp"

namespace swiftlet {
namespace {

// With several unlocalized teammates, a chain of sightings is assigned to the teammate whose odometry explains it, if
// no other odometry does.
constexpr int kMinMatched = 20;         // fewest matched sightings, at five a second
constexpr double kRefuted_sigma = 2.0;  // residual above which an odometry does not explain a chain
constexpr double kChainGap_s = 1.5;     // time without a sighting after which a chain ends
constexpr double kBody_m = 0.8;         // radius around a known vehicle within which bright returns belong to it
// [s] Time after its last bright return for which a track counts as the marked vehicle. Larger values follow it farther
// away, and other bodies that a track changes to longer.
constexpr double kMarkerMemory_s = 2.0;

class SlidingWindow : public RelativeLocalizer {
 public:
  SlidingWindow(const SlidingWindowConfig& config, const AgentSetup& setup)
      : config_(config), markers_(config.marker_reflectivity, config.body_radius_m) {
    const std::vector<VehicleId> ids = vehicles_named(config.other, config.others, setup, "relative_localization");
    teammates_.reserve(ids.size());
    for (const VehicleId id : ids) teammates_.emplace_back(id, config);
    has_report_.resize(teammates_.size());
  }

  bool needs_clouds() const override { return config_.source == SlidingWindowConfig::Source::kMarkers; }

  void step(const RelativeInput& input, std::vector<RelativeEstimate>& relatives, Outbox&) override {
    for (std::size_t i = 0; i < teammates_.size(); ++i)
      has_report_[i] = teammates_[i].receive(input.observation.messages);
    see(input);
    share_out();
    find_missing(input.observation.t);
    for (std::size_t i = 0; i < teammates_.size(); ++i) teammates_[i].update(has_report_[i]);
    for (Teammate& teammate : teammates_) {
      if (const auto estimate = teammate.estimate(input.observation.t)) relatives.push_back(*estimate);
    }
  }

  void append_overlays(std::vector<Overlay>& overlays) const override {
    for (const Teammate& teammate : teammates_) teammate.append_overlays(overlays);
  }

  void append_counters(std::vector<Counter>& counters) const override {
    std::uint64_t num_reports = 0, num_late = 0, num_starts = 0, num_lost = 0;
    for (const Teammate& teammate : teammates_) {
      num_reports += teammate.num_reports();
      num_late += teammate.num_late();
      num_starts += teammate.num_starts();
      num_lost += teammate.num_lost();
    }
    counters.push_back(
        {"sightings that were not the guided vehicle's", num_rejected_, num_sightings_, "marker_reflectivity"});
    counters.push_back({"sightings or odometry too late", num_late, num_sightings_ + num_reports, "clock"});
    counters.push_back({"losses of the guided vehicle", num_lost, std::max<std::uint64_t>(num_starts, num_lost),
                        "position_sigma_max_m"});
  }

 private:
  struct MarkedTrack {
    std::uint32_t id;
    TimeNs bright;  // time of the last bright return
  };

  // ---- sightings
  void see(const RelativeInput& input) {
    seen_.clear();
    if (config_.source == SlidingWindowConfig::Source::kMarkers) {
      bright_.clear();
      for (const auto& cloud : input.clouds) markers_.append(*cloud, bright_);
      for (const Sighting& s : bright_) take_in(s.t, s.p_local_m, s.covariance, input.poses);
    } else if (config_.source == SlidingWindowConfig::Source::kDetections) {
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
  }

  /// True for a track that was bright recently: far away, few beams meet a marker.
  bool is_marked(const Track& track) {
    if (config_.marker_reflectivity <= 0.0) return true;
    const TimeNs memory = from_seconds(kMarkerMemory_s);
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

  // ---- assignment
  /// Assigns each sighting to the known vehicle under which it is most likely; each vehicle then takes the nearest.
  /// Sightings that are left, and not near a known vehicle, may be of unlocalized teammates.
  void share_out() {
    left_.clear();
    num_missing_ = static_cast<std::size_t>(std::count_if(teammates_.begin(), teammates_.end(),
                                                          [](const Teammate& teammate) { return !teammate.known(); }));
    if (num_missing_ == teammates_.size()) {
      left_ = seen_;
      return;
    }
    choose_owners();
    for (std::size_t m = 0; m < teammates_.size(); ++m) {
      if (teammates_[m].known()) take_nearest(m);
    }
    for (std::size_t s = 0; s < seen_.size(); ++s) {
      if (owners_[s] != kAssigned && num_missing_ == 0) ++num_rejected_;
      if (owners_[s] != kAssigned && num_missing_ > 0 && !is_known_body(seen_[s])) left_.push_back(seen_[s]);
    }
  }

  void choose_owners() {
    owners_.assign(seen_.size(), kAssigned);
    for (std::size_t s = 0; s < seen_.size(); ++s) {
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t m = 0; m < teammates_.size(); ++m) {
        if (!teammates_[m].known()) continue;
        const double unlikely = teammates_[m].unlikelihood(seen_[s]);
        if (owners_[s] != kAssigned && unlikely >= least) continue;
        owners_[s] = m;
        least = unlikely;
      }
    }
  }

  void take_nearest(std::size_t m) {
    std::optional<std::size_t> nearest;
    double least = 0.0;
    for (std::size_t s = 0; s < seen_.size(); ++s) {
      if (owners_[s] != m) continue;
      const double squared = teammates_[m].squared_sigmas(seen_[s]);
      if (nearest && squared >= least) continue;
      nearest = s;
      least = squared;
    }
    if (!nearest) return;
    if (teammates_[m].take(seen_[*nearest])) {
      owners_[*nearest] = kAssigned;
    } else if (num_missing_ == 0) {
      teammates_[m].mark_ambiguous(
          seen_[*nearest].t);  // the other sighting may be the vehicle once this lasts long enough
    }
  }

  bool is_known_body(const Sighting& sighting) const {
    return std::ranges::any_of(teammates_, [&](const Teammate& teammate) {
      return teammate.known() && (teammate.place_local_m() - sighting.p_local_m).norm() < kBody_m;
    });
  }

  // ---- unlocalized teammates
  void find_missing(TimeNs now) {
    const bool has_many_bright_returns = config_.source == SlidingWindowConfig::Source::kMarkers;
    if (teammates_.size() == 1 && !has_many_bright_returns) {
      for (const Sighting& sighting : left_) teammates_.front().wait(sighting);
      return;
    }
    for (const Sighting& sighting : left_) chains_.push(sighting);
    chains_.forget_before(now - from_seconds(kChainGap_s));
    if (std::ranges::none_of(has_report_, [](char has_report) { return has_report != 0; })) return;
    for (const SightingChains::Chain& chain : chains_.chains()) {
      if (Teammate* teammate = explained_by(chain.sightings)) teammate->wait_for_new_of(chain.sightings);
    }
  }

  /// The only unlocalized teammate whose odometry explains the chain; null if there is none or another one might as
  /// well. Teammates without odometry for these seconds are skipped.
  Teammate* explained_by(std::span<const Sighting> chain) {
    Teammate* found = nullptr;
    for (Teammate& teammate : teammates_) {
      if (teammate.known()) continue;
      const MotionMatch match = teammate.match(chain);
      if (2 * match.count < kMinMatched || match.residual_sigma > kRefuted_sigma) continue;
      const bool fits = match.count >= kMinMatched && match.residual_sigma <= config_.alignment.residual_sigma_max &&
                        match.spread_m >= config_.alignment.min_spread_m;
      if (!fits || found != nullptr) return nullptr;
      found = &teammate;
    }
    return found;
  }

  static constexpr std::size_t kAssigned = std::numeric_limits<std::size_t>::max();

  SlidingWindowConfig config_;
  std::vector<Teammate> teammates_;
  std::vector<char> has_report_;  // reports received in this tick, per teammate
  MarkerSightings markers_;
  std::vector<MarkedTrack> marked_;
  std::vector<Sighting> bright_, seen_, left_;  // in this tick
  std::vector<std::size_t> owners_;             // per sighting: index of its teammate, or kAssigned
  std::size_t num_missing_ = 0;
  SightingChains chains_;
  std::uint64_t num_sightings_ = 0, num_rejected_ = 0;
};

class SharedWorld : public RelativeLocalizer {
 public:
  SharedWorld(const SharedWorldConfig& config, const AgentSetup& setup) : config_(config) {
    for (const VehicleId id : vehicles_named(config.other, config.others, setup, "relative_localization")) {
      reported_.push_back({id, std::nullopt});
    }
  }

  void step(const RelativeInput& input, std::vector<RelativeEstimate>& relatives, Outbox&) override {
    for (const Message& message : input.observation.messages) {
      OdometryReport report;
      for (Reported& other : reported_) {
        if (message.from == other.id && read_message(message, report) == Reading::kDone)
          other.newest = motion_of(report);
      }
    }
    const TimeNs t = input.observation.t;
    for (const Reported& other : reported_) {
      if (!other.newest || t - other.newest->t > from_seconds(config_.timeout_s)) continue;
      relatives.push_back(FrameChange::to_local(input.estimate).relative(estimate_of(other, t)));
    }
  }

 private:
  struct Reported {
    VehicleId id;
    std::optional<OtherMotion> newest;  // latest report, in the world
  };

  RelativeEstimate estimate_of(const Reported& other, TimeNs t) const {
    const OtherMotion& newest = *other.newest;
    const double since_s = to_seconds(t - newest.t);
    RelativeEstimate estimate;
    estimate.t = t;
    estimate.other = other.id;
    estimate.position_m = newest.p_other_local_m + since_s * newest.v_other_local_mps;
    estimate.velocity_mps = newest.v_other_local_mps;
    estimate.yaw_rad = std::remainder(newest.yaw_rad + since_s * newest.yaw_rate_radps, 2.0 * kPi);
    const double sigma_rad = config_.yaw_sigma_deg * kRadPerDeg;
    estimate.covariance.setZero();
    estimate.covariance.diagonal() << Vector3::Constant(config_.sigma_m * config_.sigma_m),
        Vector3::Constant(config_.sigma_m * config_.sigma_m), sigma_rad * sigma_rad;
    estimate.seen = estimate.report_t = newest.t;
    estimate.report_stamp = newest.stamp;
    estimate.report_position_m = newest.p_other_local_m;
    estimate.report_yaw_rad = newest.yaw_rad;
    return estimate;
  }

  SharedWorldConfig config_;
  std::vector<Reported> reported_;
};

void check_names(ConfigVisitor& v, const std::string& other, const std::vector<std::string>& others) {
  v.check(other.empty() || others.empty(), "others", "none where other names one");
}

}  // namespace

void SlidingWindowConfig::visit(ConfigVisitor& v) {
  v.field(
      "other", other,
      "[-] name of the vehicle to localize, which reports its odometry (follow_guide); empty: the first other vehicle");
  v.field("others", others,
          "[-] names of several vehicles, which are distinguished by their motion and must move differently");
  v.choice("source", source, {"detections", "tracks", "markers"},
           "[-] source of sightings: detections, the clusters on which tracks were corrected, or all bright returns of "
           "a scan");
  v.field("marker_reflectivity", marker_reflectivity,
          "[-] minimum reflectivity of the brightest return of a sighting of markers (1: white "
          "Lambertian, retro-reflectors 10 and more); 0: no markers, all sightings count",
          Range::non_negative());
  v.field("body_radius_m", body_radius_m,
          "[m] with markers: radius around a vehicle's center in which all returns belong to it",
          Range{0.0, 2.0, true});
  v.field("center_behind_m", center_behind_m,
          "[m] distance from the middle of the returns to the center of the other, along the line of sight: only its "
          "near side is seen",
          Range::between(-1.0, 1.0));
  v.field("center_above_m", center_above_m, "[m] height of the center of the vehicle above the middle of the returns",
          Range::between(-1.0, 1.0));
  v.choice("clock", clock, {"synchronized", "one_way"},
           "[-] clock of the other vehicle: synchronized with the own one (NTP), or any, estimated from the fastest "
           "message");
  v.field("position_sigma_max_m", position_sigma_max_m,
          "[m] standard deviation of its position above which the other vehicle is lost", Range::positive());
  v.object("filter", filter, "Kalman filter of position, velocity and alignment of the other vehicle");
  v.object("drift", drift, "drift of the other vehicle's odometry");
  v.check(source != Source::kMarkers || marker_reflectivity > 0.0, "marker_reflectivity", "more than 0 with markers");
  check_names(v, other, others);
}

void SharedWorldConfig::visit(ConfigVisitor& v) {
  v.field("other", other,
          "[-] name of the vehicle to localize, which reports its odometry and started from a known pose; empty: the "
          "first other vehicle");
  v.field("others", others, "[-] names of several vehicles");
  v.field("sigma_m", sigma_m, "[m] standard deviation of the reported position, per axis", Range::positive());
  v.field("yaw_sigma_deg", yaw_sigma_deg, "[deg] standard deviation of the reported heading", Range::positive());
  v.field("timeout_s", timeout_s, "[s] time without a message after which a vehicle's position is unknown",
          Range::positive());
  check_names(v, other, others);
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
