// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/shared_tracks/shared_tracks.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/shared_tracks/frame_link.hpp"
#include "core/shared_tracks/observer_bodies.hpp"
#include "core/shared_tracks/track_fusion.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/core/messages/track_report.hpp"
#include "swiftlet/core/tracking/trackers.hpp"

namespace swiftlet {
namespace {

/// [ns] Sampling period of the own path. Larger values interpolate more coarsely.
constexpr TimeNs kOwnPeriod = kNsPerSecond / 10;
/// [ns] Tolerance of message times in the future, for differing clocks. Smaller values drop reports of fast clocks.
constexpr TimeNs kAhead = kNsPerSecond / 10;
/// [m/s] Standard deviation of an observer's own velocity, per axis. Larger values mark other tracks as observers.
constexpr double kOwnVelocity_sigma_mps = 0.1;
/// [-] Least probability of existence of own tracks that are shared. Smaller values share more clutter; the detector's
/// reported_existence must be as low.
constexpr double kSharedExistence = 0.1;
/// [s] Age of a report up to which its tracks count as measured now. Larger values count old reports as new evidence.
constexpr double kFresh_s = 0.3;
// [rad] Standard deviation of a teammate's reported heading, added to that of the alignment. Larger values state a less
// certain heading.
constexpr double kHeadingNoise_rad = 0.01;

bool is_covariance(const Matrix6& C) {
  return C.allFinite() && C.diagonal().minCoeff() > 0.0 && C.llt().info() == Eigen::Success;
}

MotionEstimate estimate_of(const Track& track) {
  MotionEstimate out;
  out.mean << track.position_m, track.velocity_mps;
  out.covariance = track.covariance.topLeftCorner<6, 6>();
  return out;
}

TrackReport::Entry entry_of(const Track& track, double existence, TimeNs now) {
  TrackReport::Entry entry;
  entry.identity = track.id;
  entry.age_s = static_cast<float>(std::max(0.0, to_seconds(now - track.t)));
  entry.existence = static_cast<float>(existence);
  entry.p_local_m = track.position_m.cast<float>();
  entry.v_local_mps = track.velocity_mps.cast<float>();
  entry.covariance = track.covariance.topLeftCorner<6, 6>().cast<float>();
  return entry;
}

/// Another observer: its reports and the alignment of its frame.
struct Peer {
  struct ReportedTrack {
    std::uint32_t identity = 0;
    TimeNs t = 0;
    MotionEstimate estimate;  // in the peer's frame
    double existence = 0.0;
  };

  VehicleId id = kNoVehicle;
  FrameLink link;
  ObserverHistory history;
  TimeNs newest = -1;
  MotionEstimate self;  // at `newest`
  double yaw_rad = 0.0, yaw_rate_radps = 0.0;
  std::vector<ReportedTrack> reported;
};

class SharedTracks : public Tracker {
 public:
  SharedTracks(const SharedTracksConfig& config, const AgentSetup& setup, std::unique_ptr<Tracker> own)
      : config_(config), self_(setup.self), own_(std::move(own)), bodies_(config), fusion_(config.fusion) {}

  bool step(const TrackerInput& input, std::vector<Track>& tracks, Outbox& outbox) override {
    remember_self(input.observation.t, input.estimate);
    for (const Message& message : input.observation.messages) receive(message);
    if (!own_->step(input, own_tracks_, outbox)) return false;
    find_existences(input);
    remember_own(input);
    const TimeNs oldest = input.observation.t - from_seconds(config_.frame.window_s);
    own_history_.forget_before(oldest);
    for (Peer& peer : peers_) {
      peer.history.forget_before(oldest);
      peer.link.update(own_history_, peer.history);
    }
    fuse(input.observation.t);
    report(tracks);
    send(input, outbox);
    return true;
  }

  void append_relatives(TimeNs t, std::vector<RelativeEstimate>& relatives) const override {
    for (const Peer& peer : peers_) {
      if (const auto known = place_of(peer, t)) relatives.push_back(*known);
    }
  }

  void append_counters(std::vector<Counter>& counters) const override {
    own_->append_counters(counters);
    std::uint64_t num_starts = 0, num_lost = 0;
    for (const Peer& peer : peers_) {
      num_starts += peer.link.num_starts();
      num_lost += peer.link.num_lost();
    }
    counters.push_back({"track messages received after a newer one", num_outdated_, num_received_, "rate_hz"});
    counters.push_back({"track messages that could not be read", num_unreadable_, num_received_, "rate_hz"});
    counters.push_back({"tracks left out of a full report", num_unsent_, num_own_, "max_sent"});
    counters.push_back({"losses of the alignment with another observer's frame", num_lost,
                        std::max(num_starts, num_lost), "drift.position_m_psqrtm"});
    counters.push_back(
        {"fused targets that were split again", fusion_.num_broken(), fusion_.num_joined(), "drift.position_m_psqrtm"});
  }

 private:
  // ---- input
  void remember_self(TimeNs t, const StateEstimate& estimate) {
    const SampledPath& path = own_history_.self();
    if (!path.empty() && t - path.newest().t < kOwnPeriod) return;
    own_history_.push_self(t, estimate.T_local_body.translation(), estimate.v_local_mps,
                           yaw_of(estimate.T_local_body.linear()), config_.frame.sigma_own_m);
  }

  void remember_own(const TrackerInput& input) {
    TimeNs until = own_tracks_.empty() ? input.observation.t : std::numeric_limits<TimeNs>::max();
    for (const Track& track : own_tracks_) {
      until = std::min(until, track.t);
      own_history_.push_track(track.id, track.t, track.position_m, track.velocity_mps,
                              track.covariance.topLeftCorner<3, 3>());
    }
    own_history_.complete_until(until);
  }

  void receive(const Message& message) {
    TrackReport received;
    const Reading reading = read_message(message, received);
    if (reading == Reading::kOtherKind || message.from == self_ || message.from == kNoVehicle) return;
    ++num_received_;
    if (reading != Reading::kDone || received.t > message.received + kAhead) {
      ++num_unreadable_;
      return;
    }
    Peer& peer = peer_of(message.from);
    if (peer.newest >= 0 && received.t + kClockJump < peer.newest) start_over(peer);
    if (received.t <= peer.newest) {
      ++num_outdated_;
      return;
    }
    take(peer, received);
  }

  Peer& peer_of(VehicleId id) {
    auto peer = std::lower_bound(peers_.begin(), peers_.end(), id, [](const Peer& p, VehicleId v) { return p.id < v; });
    if (peer == peers_.end() || peer->id != id) {
      peer = peers_.insert(peer, {id, FrameLink(config_.frame, config_.drift), {}, -1, {}, 0.0, 0.0, {}});
    }
    return *peer;
  }

  static void start_over(Peer& peer) {
    peer.link.clear();
    peer.history.clear();
    peer.newest = -1;
  }

  void take(Peer& peer, const TrackReport& received) {
    peer.newest = received.t;
    peer.self.mean << received.p_local_m, received.v_local_mps;
    peer.self.covariance.setIdentity();
    const double sigma_m = config_.frame.sigma_own_m;
    peer.self.covariance.diagonal().head<3>().setConstant(sigma_m * sigma_m);
    peer.self.covariance.diagonal().tail<3>().setConstant(kOwnVelocity_sigma_mps * kOwnVelocity_sigma_mps);
    peer.yaw_rad = received.yaw_rad;
    peer.yaw_rate_radps = received.yaw_rate_radps;
    peer.history.push_self(received.t, received.p_local_m, received.v_local_mps, received.yaw_rad, sigma_m);
    peer.reported.clear();
    TimeNs until = received.t;
    for (const TrackReport::Entry& track : received.tracks) {
      Peer::ReportedTrack known{track.identity, received.t - from_seconds(track.age_s), {}, track.existence};
      known.estimate.mean << track.p_local_m.cast<double>(), track.v_local_mps.cast<double>();
      known.estimate.covariance = track.covariance.cast<double>();
      const bool is_sound = is_covariance(known.estimate.covariance) && track.existence >= 0.0F &&
                            track.existence <= 1.0F && track.age_s >= 0.0F && track.age_s < 10.0F;
      if (!is_sound) {
        ++num_unreadable_;
        continue;
      }
      until = std::min(until, known.t);
      peer.history.push_track(track.identity, known.t, known.estimate.p_m(), known.estimate.v_mps(),
                              known.estimate.covariance.topLeftCorner<3, 3>());
      peer.reported.push_back(std::move(known));
    }
    std::sort(peer.reported.begin(), peer.reported.end(),
              [](const auto& a, const auto& b) { return a.identity < b.identity; });
    peer.history.complete_until(until);
  }

  /// A track-before-detect detector lists detection i for its track i.
  void find_existences(const TrackerInput& input) {
    existences_.assign(own_tracks_.size(), config_.certainty);
    if (input.detector_tracks.size() != input.detections.size()) return;
    for (std::size_t i = 0; i < own_tracks_.size(); ++i) {
      for (std::size_t k = 0; k < input.detections.size(); ++k) {
        if (input.detector_tracks[k].id == own_tracks_[i].id) existences_[i] = input.detections[k].confidence;
      }
    }
  }

  // ---- fusion
  void fuse(TimeNs now) {
    t_ = newest(now);
    observed_.clear();
    for (std::size_t i = 0; i < own_tracks_.size(); ++i) {
      const Track& track = own_tracks_[i];
      observed_.push_back({self_, track.id, at(estimate_of(track), track.t, t_), existences_[i]});
    }
    for (const Peer& peer : peers_) {
      if (!counts(peer, now)) continue;
      for (const Peer::ReportedTrack& track : peer.reported) {
        const MotionEstimate local = in_own_frame(*peer.link.alignment(), track.estimate);
        observed_.push_back({peer.id, track.identity, at(local, track.t, t_), track.existence});
      }
    }
    leave_out_observers(t_, now);
    fusion_.update(t_, observed_);
  }

  /// Time of the newest track of all observers; without any, now.
  TimeNs newest(TimeNs now) const {
    TimeNs t = -1;
    for (const Track& track : own_tracks_) t = std::max(t, track.t);
    for (const Peer& peer : peers_) {
      if (!counts(peer, now)) continue;
      for (const Peer::ReportedTrack& track : peer.reported) t = std::max(t, track.t);
    }
    return t >= 0 ? t : now;
  }

  /// Predicts with white acceleration; estimates newer than `to` are unchanged.
  MotionEstimate at(const MotionEstimate& estimate, TimeNs from, TimeNs to) const {
    return predicted(estimate, std::max(0.0, to_seconds(to - from)), config_.acceleration_density);
  }

  bool counts(const Peer& peer, TimeNs now) const {
    return peer.link.alignment() && now - peer.newest <= from_seconds(config_.timeout_s);
  }

  /// Removes tracks that are observers.
  void leave_out_observers(TimeNs t, TimeNs now) {
    bodies_.forget_before(t - from_seconds(config_.fusion.remember_s));
    if (const auto own = own_history_.self().empty() ? std::nullopt : std::optional(own_place(t))) {
      bodies_.mark(self_, *own, t, observed_);
    }
    for (const Peer& peer : peers_) {
      if (!counts(peer, now)) continue;
      bodies_.mark(peer.id, at(in_own_frame(*peer.link.alignment(), peer.self), peer.newest, t), t, observed_);
    }
    std::erase_if(observed_, [&](const ObservedTrack& o) { return bodies_.contain(o); });
  }

  MotionEstimate own_place(TimeNs t) const {
    const SampledPath& path = own_history_.self();
    const auto then = path.at(t, config_.frame.gap_max_s);
    const PathSample& sample = then ? *then : path.newest();
    MotionEstimate out;
    out.mean << sample.p_local_m, sample.v_local_mps;
    out.covariance.setZero();
    out.covariance.diagonal().head<3>().setConstant(config_.frame.sigma_own_m * config_.frame.sigma_own_m);
    out.covariance.diagonal().tail<3>().setConstant(kOwnVelocity_sigma_mps * kOwnVelocity_sigma_mps);
    return at(out, sample.t, t);
  }

  void report(std::vector<Track>& tracks) const {
    tracks.clear();
    for (const FusedTrack& fused : fusion_.reported()) {
      Track& track = tracks.emplace_back();
      track.id = fused.id;
      track.t = t_;
      track.position_m = track.measured_m = fused.estimate.p_m();
      track.velocity_mps = fused.estimate.v_mps();
      track.covariance.topLeftCorner<6, 6>() = fused.estimate.covariance;
      track.measured_covariance = fused.estimate.covariance.topLeftCorner<3, 3>();
      for (const std::size_t m : fused.members) add_member(observed_[m], track);
    }
  }

  void add_member(const ObservedTrack& member, Track& track) const {
    if (member.observer != self_) {
      const auto peer =
          std::find_if(peers_.begin(), peers_.end(), [&](const Peer& p) { return p.id == member.observer; });
      track.corrected = track.corrected || to_seconds(t_ - peer->newest) <= kFresh_s;
      ++track.num_detections;
      return;
    }
    const auto own =
        std::find_if(own_tracks_.begin(), own_tracks_.end(), [&](const Track& t) { return t.id == member.identity; });
    track.num_detections += own->num_detections;
    track.reflectivity = own->reflectivity;
    if (!own->corrected) return;
    track.corrected = true;
    track.measured_m = own->measured_m;
    track.measured_covariance = own->measured_covariance;
  }

  // ---- output
  void send(const TrackerInput& input, Outbox& outbox) {
    const TimeNs t = input.observation.t;
    if (last_sent_ >= 0 && to_seconds(t - last_sent_) < (1.0 - 1e-6) / config_.rate_hz) return;
    last_sent_ = t;
    TrackReport sent;
    const StateEstimate& estimate = input.estimate;
    sent.t = t;
    sent.p_local_m = estimate.T_local_body.translation();
    sent.v_local_mps = estimate.v_local_mps;
    sent.yaw_rad = yaw_of(estimate.T_local_body.linear());
    sent.yaw_rate_radps = (estimate.T_local_body.linear() * estimate.omega_body_radps).z();
    order_.clear();
    for (std::size_t i = 0; i < own_tracks_.size(); ++i) {
      ++num_own_;
      if (existences_[i] >= kSharedExistence) order_.push_back(i);
    }
    std::stable_sort(order_.begin(), order_.end(),
                     [&](std::size_t a, std::size_t b) { return existences_[a] > existences_[b]; });
    const auto most = static_cast<std::size_t>(config_.max_sent);
    if (order_.size() > most) {
      num_unsent_ += order_.size() - most;
      order_.resize(most);
    }
    for (const std::size_t i : order_) sent.tracks.push_back(entry_of(own_tracks_[i], existences_[i], t));
    write_message(sent, outbox.add());
  }

  std::optional<RelativeEstimate> place_of(const Peer& peer, TimeNs t) const {
    if (!counts(peer, t)) return std::nullopt;
    const FrameAlignment& alignment = *peer.link.alignment();
    const MotionEstimate at_report = in_own_frame(alignment, peer.self), now = at(at_report, peer.newest, t);
    RelativeEstimate out;
    out.t = t;
    out.other = peer.id;
    out.position_m = now.p_m();
    out.velocity_mps = now.v_mps();
    const double since_s = to_seconds(t - peer.newest);
    out.yaw_rad = std::remainder(alignment.yaw_rad + peer.yaw_rad + since_s * peer.yaw_rate_radps, 2.0 * kPi);
    out.covariance.setZero();
    out.covariance.topLeftCorner<6, 6>() = now.covariance;
    out.covariance(6, 6) = alignment.covariance(3, 3) + kHeadingNoise_rad * kHeadingNoise_rad;
    out.seen = peer.link.measured();
    out.report_t = out.report_stamp = peer.newest;
    out.report_position_m = at_report.p_m();
    out.report_yaw_rad = std::remainder(alignment.yaw_rad + peer.yaw_rad, 2.0 * kPi);
    return out;
  }

  SharedTracksConfig config_;
  VehicleId self_;
  std::unique_ptr<Tracker> own_;
  std::vector<Track> own_tracks_;  // newest own tracks
  std::vector<double> existences_;
  ObserverHistory own_history_;
  std::vector<Peer> peers_;  // sorted by id
  ObserverBodies bodies_;
  TrackFusion fusion_;
  std::vector<ObservedTrack> observed_;  // input of the newest fusion, own tracks first
  TimeNs t_ = 0;                         // time of the newest fusion
  TimeNs last_sent_ = -1;
  std::vector<std::size_t> order_;
  std::uint64_t num_received_ = 0, num_outdated_ = 0, num_unreadable_ = 0, num_own_ = 0, num_unsent_ = 0;
};

}  // namespace

void SharedTracksConfig::visit(ConfigVisitor& v) {
  v.field("rate_hz", rate_hz, "[Hz] rate of messages, at most that of the detector's scans", Range{0.0, 100.0, true});
  v.field("max_sent", max_sent, "[-] largest number of tracks in a message, the most likely ones first; 120 bytes each",
          Range::between(0, 500));
  v.field("timeout_s", timeout_s, "[s] time after the newest message for which an observer's tracks are used",
          Range::positive());
  v.object("drift", drift, "drift of each observer's odometry");
  v.object("fusion", fusion, "fusion of tracks of one target");
}

std::unique_ptr<Tracker> make_shared_tracks(const SharedTracksConfig& config, const AgentSetup& setup,
                                            std::unique_ptr<Tracker> own) {
  return std::make_unique<SharedTracks>(config, setup, std::move(own));
}

std::unique_ptr<Tracker> make_shared_tracks(const ModuleConfig& config, const AgentSetup& setup) {
  return make_shared_tracks(dynamic_cast<const SharedTracksConfig&>(config), setup,
                            make_detector_tracks(DetectorTracksConfig{}, setup));
}

}  // namespace swiftlet
