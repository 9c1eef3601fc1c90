// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "swiftlet/sim/replay/replay.hpp"

namespace swiftlet::sim {

/// Serves the page of a run while it goes on, on 127.0.0.1 alone and under an address that nobody can guess. It answers
/// requests to read and no others. A thread of its own answers, so the run does not wait.
class LiveServer {
 public:
  /// Throws std::runtime_error when there is no port.
  LiveServer();
  ~LiveServer();

  /// "http://127.0.0.1:40123/<32 random digits>/"
  const std::string& address() const;
  /// One block more of the page, packed.
  void put(std::string packed);
  /// After the last block: waits until a page that is open has it, but not for one that has fallen silent.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Tells the server what the recorder `replay` would write. The server outlives it.
std::unique_ptr<Recorder> make_live_recorder(const ReplayConfig& config, LiveServer& server);

}  // namespace swiftlet::sim
