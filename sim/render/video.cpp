// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/video.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

extern char** environ;

namespace swiftlet::sim {
namespace {

int wait_for(int child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

}  // namespace

VideoWriter::VideoWriter(std::filesystem::path path, int width, int height, double frames_per_s)
    : path_(std::move(path)), width_(width), height_(height) {
  file_ = PartialFile(path_, path_.parent_path() / (path_.stem().string() + ".part.mp4"));
  std::error_code ignored;
  std::filesystem::remove(file_.partial(), ignored);  // ffmpeg would follow a link
  std::vector<std::string> arguments = {"ffmpeg", "-loglevel", "error", "-nostdin", "-y", "-f", "rawvideo", "-pix_fmt",
                                        "rgb24", "-video_size", std::to_string(width) + "x" + std::to_string(height),
                                        "-framerate", fmt::format("{:f}", frames_per_s), "-i", "pipe:0",
                                        // H.264 players require even sizes and 4:2:0.
                                        "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-preset",
                                        "veryfast", "-crf", "20", "-pix_fmt", "yuv420p", "-movflags", "+faststart",
                                        // Prevents ffmpeg from reading the name as an option or protocol.
                                        "file:" + std::filesystem::absolute(file_.partial()).string()};
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);

  // A socket instead of a pipe: writing to a finished ffmpeg gives an error instead of a signal.
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
    throw std::runtime_error(path_.string() + ": cannot start ffmpeg: " + std::strerror(errno));
  }
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
  const int error = posix_spawnp(&child_, "ffmpeg", &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  pipe_ = ends[0];
  if (error != 0) {
    close(pipe_);
    const std::string reason = error == ENOENT ? "ffmpeg is not installed (package ffmpeg)" : std::strerror(error);
    throw std::runtime_error(path_.string() + ": cannot make a video: " + reason);
  }
}

VideoWriter::~VideoWriter() {
  if (child_ < 0) return;
  kill(child_, SIGKILL);
  close(pipe_);
  wait_for(child_);
}

void VideoWriter::add(const Image& frame) {
  if (frame.width != width_ || frame.height != height_) {
    throw std::invalid_argument(path_.string() + ": every frame of a video has the same size");
  }
  const std::uint8_t* data = frame.rgb.data();
  std::size_t left = frame.rgb.size();
  while (left > 0) {
    const ssize_t sent = send(pipe_, data, left, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) throw std::runtime_error(path_.string() + ": ffmpeg ended early: " + std::strerror(errno));
    data += sent;
    left -= static_cast<std::size_t>(sent);
  }
}

void VideoWriter::finish() {
  close(pipe_);
  const int status = wait_for(std::exchange(child_, -1));
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    file_.abandon();
    throw std::runtime_error(path_.string() + ": ffmpeg could not make the video");
  }
  file_.commit();
}

}  // namespace swiftlet::sim
