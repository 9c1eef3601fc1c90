// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace swiftlet::sim {

/// An OpenGL 4.5 core context in software, without window or display. Everything is drawn into framebuffer objects, and
/// every function comes from proc_address(). cmake/Pictures.cmake compiles gl_context_osmesa.cpp or gl_context_egl.cpp.
class GlContext {
 public:
  /// The new context is the one of the calling thread. Throws std::runtime_error where this machine has none.
  GlContext();
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  /// Makes it the context of the calling thread. It must not be the context of another thread.
  void make_current();
  /// Leaves the calling thread without a context, so that any thread may be the next.
  void release();

  using Function = void (*)();
  static Function proc_address(const char* name);

 private:
  void* context_ = nullptr;
  alignas(16) unsigned char buffer_[4 * 16 * 16] = {};  // OSMesa wants a default framebuffer; nothing is drawn there
};

}  // namespace swiftlet::sim
