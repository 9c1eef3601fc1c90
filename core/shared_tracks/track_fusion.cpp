// SPDX-License-Identifier: BSD-3-Clause
#include "core/shared_tracks/track_fusion.hpp"

#include <algorithm>

namespace swiftlet {
namespace {

/// [-] Maximum number of identities of a target over all observers; the newest are kept. Larger values link older
/// identities.
constexpr std::ptrdiff_t kMaxKeys = 64;
/// [-] Share of false tracks that all observers have in common. Larger values give a second observer less weight; at 1
/// it adds no evidence.
constexpr double kCommonClutter = 0.1;

}  // namespace

void TrackFusionConfig::visit(ConfigVisitor& v) {
  v.field("reported_existence", reported_existence, "[-] minimum probability of existence of targets that are reported",
          Range::probability());
}

void TrackFusion::update(TimeNs t, std::span<const ObservedTrack> observed) {
  attach(observed);
  separate(observed);
  for (Target& target : targets_) {
    target.held_back = false;
    if (target.members.empty()) continue;
    target.last = t;
    fuse(target, observed);
  }
  std::erase_if(targets_, [&](const Target& target) { return t - target.last > from_seconds(config_.remember_s); });
  find_pairs(t, observed);
  join(observed);
  hold_back(observed);
  std::erase_if(targets_, [](const Target& target) { return target.keys.empty(); });  // joined into others
  report();
}

TrackFusion::Target& TrackFusion::begin(const Key& key) {
  Target& target = targets_.emplace_back();
  target.serial = next_serial_++;
  target.keys.push_back(key);
  return target;
}

/// Assigns each track to its target; an unknown one begins a target of its own.
void TrackFusion::attach(std::span<const ObservedTrack> observed) {
  for (Target& target : targets_) target.members.clear();
  for (std::size_t i = 0; i < observed.size(); ++i) {
    const Key key{observed[i].observer, observed[i].identity};
    const auto known = std::find_if(targets_.begin(), targets_.end(), [&](const Target& target) {
      return std::find(target.keys.begin(), target.keys.end(), key) != target.keys.end();
    });
    (known != targets_.end() ? *known : begin(key)).members.push_back(i);
  }
}

/// Removes tracks that no longer agree with the other tracks of their target, the worst first, and second tracks of one
/// observer: a dropped identity that has reappeared.
void TrackFusion::separate(std::span<const ObservedTrack> observed) {
  for (std::size_t k = 0; k < targets_.size(); ++k) {
    while (const auto leaves = misfit(targets_[k], observed)) {
      Target& target = targets_[k];
      const std::size_t track = target.members[*leaves];
      const Key key{observed[track].observer, observed[track].identity};
      target.members.erase(target.members.begin() + static_cast<std::ptrdiff_t>(*leaves));
      std::erase(target.keys, key);
      ++num_broken_;
      begin(key).members.push_back(track);
    }
  }
}

/// Member to be removed, if any: of two that disagree, that of the later observer.
std::optional<std::size_t> TrackFusion::misfit(const Target& target, std::span<const ObservedTrack> observed) const {
  const auto observer = [&](std::size_t m) { return observed[target.members[m]].observer; };
  const std::size_t count = target.members.size();
  const auto has_duplicate = [&](std::size_t m) {
    for (std::size_t n = 0; n < count; ++n) {
      if (n != m && observer(n) == observer(m)) return true;
    }
    return false;
  };
  bool any_duplicates = false;
  for (std::size_t m = 0; m < count; ++m) any_duplicates = any_duplicates || has_duplicate(m);
  std::optional<std::size_t> worst;
  double farthest = 0.0;
  for (std::size_t m = 0; m < count; ++m) {
    if (any_duplicates && !has_duplicate(m)) continue;
    std::vector<MotionEstimate> others;
    for (std::size_t n = 0; n < count; ++n) {
      if (observer(n) != observer(m)) others.push_back(observed[target.members[n]].estimate);
    }
    const double off =
        others.empty()
            ? 0.0
            : disagreement(observed[target.members[m]].estimate, covariance_intersection(others)).squared_sigmas;
    if (off < farthest) continue;
    worst = m;
    farthest = off;
  }
  if (!any_duplicates && farthest <= config_.break_sq) return std::nullopt;
  return worst;
}

void TrackFusion::fuse(Target& target, std::span<const ObservedTrack> observed) const {
  std::vector<MotionEstimate> estimates;
  std::vector<double> existences;
  for (const std::size_t m : target.members) {
    estimates.push_back(observed[m].estimate);
    existences.push_back(observed[m].existence);
  }
  target.estimate = covariance_intersection(estimates);
  target.existence = joint_existence(existences, config_.prior_existence, kCommonClutter);
}

bool TrackFusion::disjoint(const Target& a, const Target& b, std::span<const ObservedTrack> observed) const {
  for (const std::size_t m : a.members) {
    for (const std::size_t n : b.members) {
      if (observed[m].observer == observed[n].observer) return false;
    }
  }
  return true;
}

TrackFusion::Candidate* TrackFusion::candidate_of(const Target& a, const Target& b) {
  const auto known = std::find_if(candidates_.begin(), candidates_.end(),
                                  [&](const Candidate& s) { return s.first == a.serial && s.second == b.serial; });
  return known != candidates_.end() ? &*known : nullptr;
}

void TrackFusion::find_pairs(TimeNs t, std::span<const ObservedTrack> observed) {
  pairs_.clear();
  for (std::size_t a = 0; a < targets_.size(); ++a) {
    for (std::size_t b = a + 1; b < targets_.size(); ++b) {
      if (targets_[a].members.empty() || targets_[b].members.empty()) continue;
      if (!disjoint(targets_[a], targets_[b], observed)) continue;
      const Disagreement found = disagreement(targets_[a].estimate, targets_[b].estimate);
      // Hysteresis: a suspected pair keeps the wider gate, since a turn of the target causes brief disagreement.
      const double gate_sq = candidate_of(targets_[a], targets_[b]) != nullptr ? config_.break_sq : config_.gate_sq;
      if (found.squared_sigmas <= gate_sq) pairs_.push_back({a, b, found, true});
    }
  }
  for (Candidate& candidate : candidates_) candidate.now = false;
  for (Pair& pair : pairs_) {
    Candidate* known = candidate_of(targets_[pair.a], targets_[pair.b]);
    if (known == nullptr) {
      candidates_.push_back({targets_[pair.a].serial, targets_[pair.b].serial, t, 0, true});
      known = &candidates_.back();
    }
    known->now = true;
    const bool agrees = pair.disagreement.squared_sigmas <= config_.merge_sq;
    const bool is_sure = agrees && pair.disagreement.position_sigma_m <= config_.sure_m && is_likeliest(pair);
    known->agreed = std::max(0, known->agreed + (is_sure ? 1 : -1));
    if (agrees) known->since = t;
    pair.is_open = t - known->since <= from_seconds(config_.split_after_s);
  }
  std::erase_if(candidates_, [](const Candidate& candidate) { return !candidate.now; });
}

/// No rival pair of either target is nearly as likely.
bool TrackFusion::is_likeliest(const Pair& pair) const {
  return std::none_of(pairs_.begin(), pairs_.end(), [&](const Pair& other) {
    if (&other == &pair) return false;
    return are_rivals(pair, other) && other.disagreement.unlikelihood < pair.disagreement.unlikelihood + config_.margin;
  });
}

/// Two pairs are rivals if they share a target and their other targets cannot be one. A third observer's track of the
/// same target is no rival: both may join in turn.
bool TrackFusion::are_rivals(const Pair& pair, const Pair& other) const {
  std::size_t x = 0, y = 0;
  if (other.a == pair.a) {
    x = pair.b, y = other.b;
  } else if (other.b == pair.b) {
    x = pair.a, y = other.a;
  } else if (other.a == pair.b) {
    x = pair.a, y = other.b;
  } else if (other.b == pair.a) {
    x = pair.b, y = other.a;
  } else {
    return false;
  }
  return std::none_of(pairs_.begin(), pairs_.end(),
                      [&](const Pair& p) { return p.a == std::min(x, y) && p.b == std::max(x, y); });
}

void TrackFusion::join(std::span<const ObservedTrack> observed) {
  std::vector<char> touched(targets_.size(), 0);
  for (const Pair& pair : pairs_) {
    if (touched[pair.a] || touched[pair.b]) continue;
    const Candidate* candidate = candidate_of(targets_[pair.a], targets_[pair.b]);
    if (candidate == nullptr || candidate->agreed < config_.confirmations) continue;
    touched[pair.a] = touched[pair.b] = 1;
    Target &kept = targets_[pair.a], &gone = targets_[pair.b];
    kept.keys.insert(kept.keys.end(), gone.keys.begin(), gone.keys.end());
    if (std::ssize(kept.keys) > kMaxKeys) kept.keys.erase(kept.keys.begin(), kept.keys.end() - kMaxKeys);
    kept.members.insert(kept.members.end(), gone.members.begin(), gone.members.end());
    std::sort(kept.members.begin(), kept.members.end());
    kept.was_reported = kept.was_reported || gone.was_reported;
    if (kept.id == 0 || (gone.id != 0 && gone.id < kept.id)) kept.id = gone.id;
    gone.members.clear();
    gone.keys.clear();
    fuse(kept, observed);
    ++num_joined_;
  }
}

/// In each group of targets that may be one, only those seen by the best observer are reported.
void TrackFusion::hold_back(std::span<const ObservedTrack> observed) {
  std::vector<std::size_t> group(targets_.size());
  for (std::size_t k = 0; k < group.size(); ++k) group[k] = k;
  const auto root = [&](std::size_t k) {
    while (group[k] != k) k = group[k];
    return k;
  };
  for (const Pair& pair : pairs_) {
    const bool both = !targets_[pair.a].members.empty() && !targets_[pair.b].members.empty();
    if (!both || !pair.is_open) continue;
    const std::size_t a = root(pair.a), b = root(pair.b);
    group[std::max(a, b)] = std::min(a, b);
  }
  for (std::size_t first = 0; first < group.size(); ++first) {
    if (root(first) != first) continue;
    // For each observer, the number of its targets that are likely enough to be reported, and that were reported
    // before.
    struct Count {
      VehicleId observer;
      int likely = 0, reported = 0;
    };
    std::vector<Count> counts;
    std::size_t size = 0;
    for (std::size_t k = first; k < group.size(); ++k) {
      if (root(k) != first || targets_[k].members.empty()) continue;
      ++size;
      for (const std::size_t m : targets_[k].members) {
        auto count = std::find_if(counts.begin(), counts.end(),
                                  [&](const Count& c) { return c.observer == observed[m].observer; });
        if (count == counts.end()) count = counts.insert(count, {observed[m].observer, 0, 0});
        count->likely += targets_[k].existence >= config_.reported_existence;
        count->reported += targets_[k].was_reported;
      }
    }
    if (size < 2) continue;
    // Ties go to targets that were reported before, then to the first observer in `observed`.
    const auto order = [&](VehicleId observer) {
      return std::find_if(observed.begin(), observed.end(),
                          [&](const ObservedTrack& o) { return o.observer == observer; }) -
             observed.begin();
    };
    const auto best = std::min_element(counts.begin(), counts.end(), [&](const Count& x, const Count& y) {
      if (x.likely != y.likely) return x.likely > y.likely;
      return x.reported != y.reported ? x.reported > y.reported : order(x.observer) < order(y.observer);
    });
    for (std::size_t k = first; k < group.size(); ++k) {
      if (root(k) != first || targets_[k].members.empty()) continue;
      targets_[k].held_back = std::none_of(targets_[k].members.begin(), targets_[k].members.end(),
                                           [&](std::size_t m) { return observed[m].observer == best->observer; });
      num_held_back_ += targets_[k].held_back;
    }
  }
}

void TrackFusion::report() {
  reported_.clear();
  for (Target& target : targets_) {
    target.was_reported =
        !target.members.empty() && !target.held_back && target.existence >= config_.reported_existence;
    if (!target.was_reported) continue;
    if (target.id == 0) target.id = next_id_++;
    reported_.push_back({target.id, target.estimate, target.existence, target.members});
  }
  std::sort(reported_.begin(), reported_.end(), [](const FusedTrack& a, const FusedTrack& b) { return a.id < b.id; });
}

}  // namespace swiftlet
