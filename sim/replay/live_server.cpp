// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/replay/live_server.hpp"

#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "sim/replay/page.hpp"

namespace swiftlet::sim {
namespace {

using Clock = std::chrono::steady_clock;

/// After the end of a run, time without a request for a further block until the page counts as closed; pages request
/// far more often. Longer values delay the end of the program.
constexpr auto kPageTimeout = std::chrono::seconds(3);
/// Longest time that one connection takes to send its request, and to receive its reply; then it is closed.
/// Connections are served one after another, so this is also how long a slow client delays a page.
constexpr auto kConnectionTimeout = std::chrono::seconds(2);
// [ms] Interval at which the server and its starter check for the end. Larger values end later.
constexpr int kPoll_ms = 100;
// [bytes] Longest accepted request.
constexpr std::size_t kMaxRequest = 8192;

[[noreturn]] void fail(const char* what) {
  throw std::runtime_error(fmt::format("cannot serve the view: {}: {}", what, std::strerror(errno)));
}

std::string random_token() {
  std::array<unsigned char, 16> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) fail("getrandom");
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

std::string response(std::string_view status, std::string_view type, std::string_view body) {
  return fmt::format(
      "HTTP/1.1 {}\r\nContent-Type: {}\r\nContent-Length: {}\r\nConnection: close\r\nCache-Control: no-store\r\n"
      "X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nX-Frame-Options: DENY\r\n\r\n{}",
      status, type, body.size(), body);
}

/// Whether the connection gets ready for `what` (POLLIN, POLLOUT) before the deadline.
bool wait_for(int connection, short what, Clock::time_point deadline) {
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
  pollfd waiting{connection, what, 0};
  return left.count() > 0 && poll(&waiting, 1, static_cast<int>(left.count())) > 0;
}

/// Reads up to the empty line; empty result when the request is too long, too slow, or missing.
std::string read_request(int connection) {
  const Clock::time_point deadline = Clock::now() + kConnectionTimeout;
  std::string request;
  std::array<char, 2048> part;
  while (request.find("\r\n\r\n") == std::string::npos) {
    if (!wait_for(connection, POLLIN, deadline)) return {};
    const ssize_t count = recv(connection, part.data(), part.size(), 0);
    if (count <= 0 || request.size() + static_cast<std::size_t>(count) > kMaxRequest) return {};
    request.append(part.data(), static_cast<std::size_t>(count));
  }
  return request;
}

void send_all(int connection, std::string_view bytes) {
  const Clock::time_point deadline = Clock::now() + kConnectionTimeout;
  while (!bytes.empty() && wait_for(connection, POLLOUT, deadline)) {
    const ssize_t count = send(connection, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count <= 0) return;
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
}

}  // namespace

struct LiveServer::Impl {
  int listener = -1;
  std::string host, token, address;
  std::mutex mutex;
  std::vector<std::string> blocks;  // guarded by the mutex, like the following members
  bool last_is_there = false, last_is_taken = false;
  std::size_t num_requested = 0;  // one more than the highest block number requested so far
  // Last request for any block; after the end, for one not requested before
  Clock::time_point last_request = Clock::time_point::min();
  std::atomic<bool> stop = false;
  std::thread thread;

  void serve() {
    while (!stop) {
      pollfd waiting{listener, POLLIN, 0};
      if (poll(&waiting, 1, kPoll_ms) <= 0) continue;
      const int connection = accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
      if (connection < 0) continue;
      const std::string request = read_request(connection);
      if (!request.empty()) send_all(connection, response_to(request));
      close(connection);
    }
  }

  std::string response_to(std::string_view request) {
    const std::string_view line = request.substr(0, request.find("\r\n"));
    if (!line.starts_with("GET ")) return response("405 Method Not Allowed", "text/plain", "only GET is supported\n");
    // Rejects pages of other origins that resolve another host name to this address.
    if (request.find("\r\nHost: " + host + "\r\n") == std::string_view::npos)
      return response("403 Forbidden", "text/plain", "unknown host\n");
    const std::string_view rest = line.substr(4);
    std::string_view path = rest.substr(0, rest.find(' '));
    const std::string prefix = "/" + token + "/";
    if (!path.starts_with(prefix)) return response("404 Not Found", "text/plain", "no such page\n");
    path.remove_prefix(prefix.size());
    if (path.empty()) return response("200 OK", "text/html; charset=utf-8", page_head(PageUse::kLive) + page_tail());
    constexpr std::string_view kBlocks = "blocks/";
    std::size_t number = 0;
    if (!path.starts_with(kBlocks)) return response("404 Not Found", "text/plain", "no such page\n");
    const char* end = path.data() + path.size();
    const auto parsed = std::from_chars(path.data() + kBlocks.size(), end, number);
    if (parsed.ec != std::errc() || parsed.ptr != end) return response("404 Not Found", "text/plain", "no such page\n");
    return block(number);
  }

  std::string block(std::size_t number) {
    const std::lock_guard lock(mutex);
    if (!last_is_there) last_request = Clock::now();
    if (number >= blocks.size()) return response("204 No Content", "text/plain", "");
    if (number >= num_requested) last_request = Clock::now();
    num_requested = std::max(num_requested, number + 1);
    last_is_taken = last_is_taken || (last_is_there && number + 1 == blocks.size());
    return response("200 OK", "application/octet-stream", blocks[number]);
  }
};

LiveServer::LiveServer() : impl_(std::make_unique<Impl>()) {
  impl_->token = random_token();
  impl_->listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (impl_->listener < 0) fail("socket");
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof place;
  if (bind(impl_->listener, reinterpret_cast<sockaddr*>(&place), size) != 0 || listen(impl_->listener, 16) != 0 ||
      getsockname(impl_->listener, reinterpret_cast<sockaddr*>(&place), &size) != 0) {
    close(impl_->listener);
    fail("bind");
  }
  impl_->host = fmt::format("127.0.0.1:{}", ntohs(place.sin_port));
  impl_->address = fmt::format("http://{}/{}/", impl_->host, impl_->token);
  impl_->thread = std::thread([this] { impl_->serve(); });
}

LiveServer::~LiveServer() {
  impl_->stop = true;
  impl_->thread.join();
  close(impl_->listener);
}

const std::string& LiveServer::address() const { return impl_->address; }

void LiveServer::put(std::string packed) {
  const std::lock_guard lock(impl_->mutex);
  impl_->blocks.push_back(std::move(packed));
}

void LiveServer::finish() {
  const auto is_over = [this] {
    const std::lock_guard lock(impl_->mutex);
    if (!std::exchange(impl_->last_is_there, true))
      impl_->num_requested = 0;  // a reloaded page requests all blocks again
    return impl_->last_is_taken || impl_->last_request == Clock::time_point::min() ||
           Clock::now() - impl_->last_request > kPageTimeout;
  };
  while (!is_over()) std::this_thread::sleep_for(std::chrono::milliseconds(kPoll_ms));
}

}  // namespace swiftlet::sim
