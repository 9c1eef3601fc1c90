// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/sharing/covariance_intersection.hpp"

namespace swiftlet {

/// A track of one observer, carried into one's own local frame and to the instant of the fusion.
struct ObservedTrack {
  VehicleId observer = kNoVehicle;
  std::uint32_t identity = 0;  ///< at that observer
  MotionEstimate estimate;
  double existence = 0.0;
};

struct TrackFusionConfig {
  double told_existence = 0.5;
  double prior_existence = 2e-4;
  double common_clutter = 0.1;
  double gate_sq = 22.5;
  double merge_sq = 12.6;
  double break_sq = 33.0;
  double margin = 9.2;
  double sure_m = 1.0;
  int confirmations = 3;
  double doubt_s = 2.0;
  double remember_s = 10.0;

  void visit(ConfigVisitor& v);
};

/// What all observers together see flying.
struct FusedTrack {
  std::uint32_t id = 0;
  MotionEstimate estimate;
  double existence = 0.0;
  std::vector<std::size_t> members;  ///< indices of the observed tracks, by observer; at most one of each
};

/// Which tracks of several observers are of one target, and what they say of it together.
///
/// Tracks are joined by their identities. What was found to be one target stays one, as long as its tracks agree. Two
/// tracks of different observers are found to be one when position and velocity agree within `merge_sq`. Each must be
/// the other's likeliest partner by `margin`, and their distance must be known to `sure_m`. All of that must be so more
/// often than not (`confirmations`). In doubt they stay apart. Until that is decided, two that may be one (`gate_sq`)
/// are not both told. Of such a group the tracks of the observer are told who sees most of it. What does not agree for
/// `doubt_s` is two. Tracks of one observer are never joined, because it saw two.
///
/// Estimates are fused by covariance intersection. Why not by the sum of informations, with decorrelated tracklets
/// (Drummond, SPIE 3163, 1997)? The error of a frame's alignment is the same in all that its observer tells, for
/// seconds. And the motion of the target is the same noise for all. Neither is independent from message to message. And
/// a whole estimate needs no other message to be understood, so lost ones cost nothing but age.
class TrackFusion {
 public:
  explicit TrackFusion(const TrackFusionConfig& config) : config_(config) {}

  /// All of one instant. @param observed  by observer and identity; the first observer's are told when in doubt
  void update(TimeNs t, std::span<const ObservedTrack> observed);
  /// Those that exist with enough probability, by identity.
  std::span<const FusedTrack> told() const { return told_; }
  std::uint64_t num_joined() const { return num_joined_; }
  std::uint64_t num_broken() const { return num_broken_; }
  std::uint64_t num_held_back() const { return num_held_back_; }

 private:
  struct Key {
    VehicleId observer = kNoVehicle;
    std::uint32_t identity = 0;
    bool operator==(const Key&) const = default;
  };
  /// One target, as far as is known.
  struct Target {
    std::uint32_t serial = 0;  // of all that there ever were
    std::uint32_t id = 0;      // that is told; 0: none yet
    TimeNs last = 0;           // when it last had a track
    std::vector<Key> keys;
    std::vector<std::size_t> members;  // of this update
    MotionEstimate estimate;
    double existence = 0.0;
    bool held_back = false, was_told = false;  // the latter in the update before
  };
  /// Two targets that may be one.
  struct Suspicion {
    std::uint32_t first = 0, second = 0;  // serials
    TimeNs since = 0;
    int agreed = 0;  // times, less those that they did not
    bool now = false;
  };
  struct Pair {
    std::size_t a = 0, b = 0;  // of targets_
    Disagreement disagreement;
    bool is_open = true;  // it may still be one
  };

  void attach(std::span<const ObservedTrack> observed);
  void separate(std::span<const ObservedTrack> observed);
  void fuse(Target& target, std::span<const ObservedTrack> observed) const;
  void find_pairs(TimeNs t, std::span<const ObservedTrack> observed);
  void join(std::span<const ObservedTrack> observed);
  void hold_back(std::span<const ObservedTrack> observed);
  void tell();
  Target& begin(const Key& key);
  Suspicion* suspicion_of(const Target& a, const Target& b);  // null: they are not suspected
  bool disjoint(const Target& a, const Target& b, std::span<const ObservedTrack> observed) const;
  std::optional<std::size_t> misfit(const Target& target, std::span<const ObservedTrack> observed) const;
  bool is_likeliest(const Pair& pair) const;
  bool are_rivals(const Pair& pair, const Pair& other) const;

  TrackFusionConfig config_;
  std::vector<Target> targets_;  // by serial
  std::vector<Suspicion> suspicions_;
  std::vector<Pair> pairs_;  // of this update
  std::vector<FusedTrack> told_;
  std::uint32_t next_serial_ = 1, next_id_ = 1;
  std::uint64_t num_joined_ = 0, num_broken_ = 0, num_held_back_ = 0;
};

}  // namespace swiftlet
