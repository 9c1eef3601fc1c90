// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <string>

namespace swiftlet::tools {

/// Progress on stderr: one updated line on a terminal, otherwise plain lines every ten seconds; only for work that
/// lasts longer than two seconds. Frequent calls are cheap.
class Progress {
 public:
  Progress(std::string what, bool quiet);
  ~Progress();
  /// @param done  0..1; a smaller value than before begins a new part, for which the remaining time is estimated anew
  /// @param note  such as "12.4 s, 3.1 x real time"
  void update(double done, const std::string& note);
  /// Is it time to call update()? For callers with expensive notes.
  bool due() const;
  void finish();

 private:
  double elapsed_s() const;
  std::string what_;
  bool quiet_;
  bool terminal_;
  bool shown_ = false;
  double done_ = 0.0;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point part_start_ = start_;
  mutable std::chrono::steady_clock::time_point last_ = start_;
};

/// "3.2 s", "4 min 05 s", "2 h 03 min".
std::string duration_text(double seconds);

/// Bold or colored text on a terminal that supports it (NO_COLOR is respected), plain text elsewhere.
std::string bold(const std::string& text);

}  // namespace swiftlet::tools
