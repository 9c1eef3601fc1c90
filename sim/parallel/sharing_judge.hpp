// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

namespace swiftlet::sim {

/// Does it pay to share small loops with other threads? Alone on a machine it does. Beside other programs a second
/// thread may cost the first one more of its processor than it helps. The system shares out processors by threads, and
/// a loop of some ten microseconds gains only while both run. So both ways are tried in turns, by spans of time, and
/// the faster one is kept. Nobody tries while nobody else wants the processors.
class SharingJudge {
 public:
  /// How the loops of the next span are done.
  bool share() const { return share_; }

  /// A span is over, in which small loops were done as share() said.
  /// @param num_loops  how many
  /// @param wall_s     how long they and what lies between them took [s], more than 0
  /// @param contended  whether others wanted the processor of the thread that shares out
  void learn(int num_loops, double wall_s, bool contended);

 private:
  enum Way { kAlone, kShared };
  /// Loops a second over the spans that count, of each way.
  struct Rate {
    double num_loops = 0.0, wall_s = 0.0;
    double per_s() const { return wall_s > 0.0 ? num_loops / wall_s : 0.0; }
  };

  Rate& rate_of(bool share) { return rates_[share ? kShared : kAlone]; }
  void turn_to(bool share);

  std::array<Rate, 2> rates_;
  bool share_ = true;
  bool trying_ = false;  // the way that is not the better one
  int contention_ = 0;   // spans that were contended less those that were not, lately
  int spans_ = 0;        // since the last turn
  int spans_kept_ = 0;   // how long the better way is kept before the other one is tried again
};

}  // namespace swiftlet::sim
