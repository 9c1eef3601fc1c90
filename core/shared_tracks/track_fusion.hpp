// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/shared_tracks/covariance_intersection.hpp"
#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/shared_tracks/shared_tracks_config.hpp"

namespace swiftlet {

/// A track of one observer, transformed to the own local frame and predicted to the time of the fusion.
struct ObservedTrack {
  VehicleId observer = kNoVehicle;
  std::uint32_t identity = 0;  ///< identity at that observer
  MotionEstimate estimate;
  double existence = 0.0;
};

/// A target as estimated by all observers.
struct FusedTrack {
  std::uint32_t id = 0;
  MotionEstimate estimate;
  double existence = 0.0;
  std::vector<std::size_t> members;  ///< indices of the observed tracks, by observer; at most one of each
};

/// Associates tracks of several observers with targets, and fuses them.
///
/// Tracks are joined by identity: once associated, tracks stay joined while they agree. Two tracks of different
/// observers are joined when position and velocity agree within `merge_sq`, each is the other's likeliest partner by
/// `margin`, and their distance is known to `sure_m`, more often than not (`confirmations`). Otherwise they stay
/// separate. Until the decision, of a group of candidates (`gate_sq`) only the tracks of one observer are reported: the
/// one with the most of them. Tracks that disagree for `split_after_s` are separated. Tracks of one observer are never
/// joined, because it observed two targets.
///
/// Estimates are fused by covariance intersection rather than by summing the information of decorrelated tracklets
/// (Drummond, SPIE 3163, 1997): for seconds, the alignment error of an observer's frame is common to all its reports,
/// and the target's process noise is common to all observers, so their errors are not independent. Whole estimates are
/// also self-contained, so lost messages only increase their age.
class TrackFusion {
 public:
  explicit TrackFusion(const TrackFusionConfig& config) : config_(config) {}

  /// Fuses tracks of one time. @param observed  by observer and identity; the first observer takes precedence in doubt
  void update(TimeNs t, std::span<const ObservedTrack> observed);
  /// Targets above the reporting threshold, by identity.
  std::span<const FusedTrack> reported() const { return reported_; }
  std::uint64_t num_joined() const { return num_joined_; }
  std::uint64_t num_broken() const { return num_broken_; }
  std::uint64_t num_held_back() const { return num_held_back_; }

 private:
  struct Key {
    VehicleId observer = kNoVehicle;
    std::uint32_t identity = 0;
    bool operator==(const Key&) const = default;
  };
  /// State of one target.
  struct Target {
    std::uint32_t serial = 0;  // serial number
    std::uint32_t id = 0;      // reported id; 0: none yet
    TimeNs last = 0;           // time of its last track
    std::vector<Key> keys;
    std::vector<std::size_t> members;  // indices of its tracks in this update
    MotionEstimate estimate;
    double existence = 0.0;
    bool held_back = false, was_reported = false;  // was_reported: reported in the previous update
  };
  /// Two targets that may be the same.
  struct Candidate {
    std::uint32_t first = 0, second = 0;  // serials
    TimeNs since = 0;
    int agreed = 0;  // number of agreements minus disagreements
    bool now = false;
  };
  struct Pair {
    std::size_t a = 0, b = 0;  // indices in targets_
    Disagreement disagreement;
    bool is_open = true;  // the targets may be the same
  };

  void attach(std::span<const ObservedTrack> observed);
  void separate(std::span<const ObservedTrack> observed);
  void fuse(Target& target, std::span<const ObservedTrack> observed) const;
  void find_pairs(TimeNs t, std::span<const ObservedTrack> observed);
  void join(std::span<const ObservedTrack> observed);
  void hold_back(std::span<const ObservedTrack> observed);
  void report();
  Target& begin(const Key& key);
  Candidate* candidate_of(const Target& a, const Target& b);  // null: none
  bool disjoint(const Target& a, const Target& b, std::span<const ObservedTrack> observed) const;
  std::optional<std::size_t> misfit(const Target& target, std::span<const ObservedTrack> observed) const;
  bool is_likeliest(const Pair& pair) const;
  bool are_rivals(const Pair& pair, const Pair& other) const;

  TrackFusionConfig config_;
  std::vector<Target> targets_;  // sorted by serial
  std::vector<Candidate> candidates_;
  std::vector<Pair> pairs_;  // pairs of this update
  std::vector<FusedTrack> reported_;
  std::uint32_t next_serial_ = 1, next_id_ = 1;
  std::uint64_t num_joined_ = 0, num_broken_ = 0, num_held_back_ = 0;
};

}  // namespace swiftlet
