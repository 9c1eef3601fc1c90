// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace swiftlet::sim {

/// An OpenGL 4.5 core context in software, without window or display (OSMesa). Everything is drawn into framebuffer
/// objects and every function comes from proc_address(), so another way to a context changes gl_context.cpp only.
class GlContext {
 public:
  /// Throws std::runtime_error when there is no such context on this machine.
  GlContext();
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  /// Makes it the context of the calling thread.
  void make_current();

  using Function = void (*)();
  static Function proc_address(const char* name);

 private:
  void* context_ = nullptr;
  alignas(16) unsigned char buffer_[4 * 16 * 16] = {};  // OSMesa wants a default framebuffer; nothing is drawn there
};

}  // namespace swiftlet::sim
