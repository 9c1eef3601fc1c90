// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace swiftlet::sim {

/// An OpenGL 4.5 core context in software, without window or display. Drawing goes into framebuffer objects, and every
/// function comes from proc_address(). cmake/Pictures.cmake compiles gl_context_osmesa.cpp or gl_context_egl.cpp.
class GlContext {
 public:
  /// Makes the new context current in the calling thread. Throws std::runtime_error where this machine has none.
  GlContext();
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  /// Makes it current in the calling thread. It must not be current in another thread.
  void make_current();
  /// Releases it from the calling thread, so that another thread can use it.
  void release();

  using Function = void (*)();
  static Function proc_address(const char* name);

 private:
  void* context_ = nullptr;
  alignas(16) unsigned char buffer_[4 * 16 * 16] = {};  // required by OSMesa as default framebuffer; unused
};

}  // namespace swiftlet::sim
