// SPDX-License-Identifier: BSD-3-Clause
#include "sim/dataset/hash.hpp"

#define XXH_INLINE_ALL
#include <fcntl.h>
#include <unistd.h>
#include <xxhash.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <vector>

#include "swiftlet/sim/io/text.hpp"

namespace swiftlet::sim {
namespace {

Hash128 of(const XXH128_hash_t& hash) { return {hash.high64, hash.low64}; }

struct FreeState {
  void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
};

}  // namespace

Hash128 hash_of(std::string_view bytes) { return of(XXH3_128bits(bytes.data(), bytes.size())); }

Hash128 hash_of_file(const std::filesystem::path& path) {
  // Nonblocking: does not wait for the writer of a FIFO
  const int file = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) throw std::runtime_error("cannot read " + path.string() + ": " + std::strerror(errno));
  const std::unique_ptr<XXH3_state_t, FreeState> state(XXH3_createState());
  XXH3_128bits_reset(state.get());
  std::vector<char> buffer(1 << 18);
  for (;;) {
    const ssize_t count = ::read(file, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      const int error = errno;
      ::close(file);
      throw std::runtime_error("cannot read " + path.string() + ": " + std::strerror(error));
    }
    if (count == 0) break;
    XXH3_128bits_update(state.get(), buffer.data(), static_cast<std::size_t>(count));
  }
  ::close(file);
  return of(XXH3_128bits_digest(state.get()));
}

std::string hex(const Hash128& hash) { return hex64(hash.high) + hex64(hash.low); }

}  // namespace swiftlet::sim
