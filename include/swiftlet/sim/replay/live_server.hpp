// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "swiftlet/sim/replay/replay.hpp"

namespace swiftlet::sim {

/// HTTP server for the replay page of a run in progress. Accepts connections from this machine only (127.0.0.1), at an
/// address with a random part that cannot be guessed, and only GET requests. A separate thread serves them, so the run
/// does not wait.
class LiveServer {
 public:
  /// Throws std::runtime_error when no port is available.
  LiveServer();
  ~LiveServer();

  /// Address of the page, such as "http://127.0.0.1:40123/<32 random hexadecimal digits>/".
  const std::string& address() const;
  /// Appends one gzip-compressed ReplayBlock to the page.
  void put(std::string packed);
  /// Waits until a page has received the last block, or until no page has requested a further block for 3 s. A second
  /// page that is slower may miss the last blocks.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Makes a recorder that sends to the server what the recorder `replay` would write to its file. The server must
/// outlive the recorder.
std::unique_ptr<Recorder> make_live_recorder(const ReplayConfig& config, LiveServer& server);

}  // namespace swiftlet::sim
