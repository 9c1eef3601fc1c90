// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

namespace swiftlet::sim {

/// Decides whether small loops are shared with other threads. Sharing pays on an otherwise idle machine. Beside other
/// programs a second thread may cost the first one more processor time than it contributes: the system assigns
/// processors by thread, and a loop of some ten microseconds gains only while both threads run. Both modes are
/// therefore tried alternately for spans of time, and the faster one is kept. Without contention for the processors
/// there are no trials.
class SharingJudge {
 public:
  /// Mode of the loops in the next span.
  bool share() const { return share_; }

  /// Records a span in which small loops ran as share() returned.
  /// @param num_loops  number of loops
  /// @param wall_s     total time of the loops and the intervals between them [s], more than 0
  /// @param contended  whether other programs competed for the processor of the calling thread
  void learn(int num_loops, double wall_s, bool contended);

 private:
  enum Way { kAlone, kShared };
  /// Loops per second over the counted spans, for each mode.
  struct Rate {
    double num_loops = 0.0, wall_s = 0.0;
    double per_s() const { return wall_s > 0.0 ? num_loops / wall_s : 0.0; }
  };

  Rate& rate_of(bool share) { return rates_[share ? kShared : kAlone]; }
  void turn_to(bool share);

  std::array<Rate, 2> rates_;
  bool share_ = true;
  bool trying_ = false;  // testing the slower mode
  int contention_ = 0;   // contended minus uncontended spans, clamped
  int spans_ = 0;        // since the last change
  int spans_kept_ = 0;   // spans for which the better mode is kept before the next trial
};

}  // namespace swiftlet::sim
