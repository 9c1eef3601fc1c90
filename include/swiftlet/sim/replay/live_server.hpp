// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "swiftlet/sim/replay/replay.hpp"

namespace swiftlet::sim {

/// Serves the replay page of a run in progress, on 127.0.0.1 only and under an unguessable random address. Accepts only
/// read requests. A separate thread serves them, so the run does not wait.
class LiveServer {
 public:
  /// Throws std::runtime_error when no port is available.
  LiveServer();
  ~LiveServer();

  /// "http://127.0.0.1:40123/<32 random digits>/"
  const std::string& address() const;
  /// Appends one packed block to the page.
  void put(std::string packed);
  /// After the last block: waits until each open page has received it, except pages that have stopped responding.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Sends the server the data that the recorder `replay` would write. The server must outlive the recorder.
std::unique_ptr<Recorder> make_live_recorder(const ReplayConfig& config, LiveServer& server);

}  // namespace swiftlet::sim
