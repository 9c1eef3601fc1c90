// SPDX-License-Identifier: BSD-3-Clause
#include "sharing_judge.hpp"

#include <algorithm>

namespace swiftlet::sim {
namespace {

constexpr int kContendedAtMost = 30;
constexpr int kContendedForSure = 6;
// The system moves threads to other processors within a few time slices, so the first spans after a change are not
// counted.
constexpr int kSpansToSettle = 2;
constexpr int kSpansOfATry = 8;
// The interval between trials doubles while the kept mode wins.
constexpr int kSpansKeptAtFirst = 40;
constexpr int kSpansKeptAtMost = 320;

}  // namespace

void SharingJudge::learn(int num_loops, double wall_s, bool contended) {
  contention_ = std::clamp(contention_ + (contended ? 1 : -1), 0, kContendedAtMost);
  if (contention_ == 0) {
    *this = SharingJudge();
    return;
  }
  if (++spans_ > kSpansToSettle) {
    rate_of(share_).num_loops += num_loops;
    rate_of(share_).wall_s += wall_s;
  }
  if (trying_) {
    if (spans_ < kSpansOfATry) return;
    const bool better = rate_of(share_).per_s() > rate_of(!share_).per_s();
    trying_ = false;
    spans_kept_ = better ? kSpansKeptAtFirst : std::min(2 * spans_kept_, kSpansKeptAtMost);
    if (!better) turn_to(!share_);
    spans_ = 0;
  } else if (contention_ >= kContendedForSure && spans_ >= std::max(spans_kept_, kSpansOfATry)) {
    trying_ = true;
    spans_kept_ = std::max(spans_kept_, kSpansKeptAtFirst);
    turn_to(!share_);
  }
}

// Restarts the measured rate of the new mode; the other mode keeps its last rate for comparison.
void SharingJudge::turn_to(bool share) {
  share_ = share;
  spans_ = 0;
  rate_of(share_) = {};
}

}  // namespace swiftlet::sim
