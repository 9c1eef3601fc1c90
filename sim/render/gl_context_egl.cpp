// SPDX-License-Identifier: BSD-3-Clause
#define EGL_NO_PLATFORM_SPECIFIC_TYPES  // avoids headers of a window system
#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <stdexcept>
#include <string_view>
#include <vector>

#include "sim/render/gl_context.hpp"
#include "swiftlet/sim/render/render_config.hpp"

namespace swiftlet::sim {
namespace {

[[noreturn]] void fail() {
  throw std::runtime_error(
      "pictures need an OpenGL 4.5 core context in software, which EGL could not make here "
      "(packages libegl1 and libgl1-mesa-dri); remove `snapshots` from the scenario to run without pictures");
}

template <class Function>
Function egl_function(const char* name) {
  const auto function = reinterpret_cast<Function>(eglGetProcAddress(name));
  if (function == nullptr) fail();
  return function;
}

/// Mesa's software rasterizer: pictures are equal with and without a GPU.
EGLDeviceEXT software_device() {
  const auto query_devices = egl_function<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
  const auto query_string = egl_function<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
  EGLint count = 0;
  if (query_devices(0, nullptr, &count) == EGL_FALSE) fail();
  std::vector<EGLDeviceEXT> devices(static_cast<std::size_t>(count));
  if (query_devices(count, devices.data(), &count) == EGL_FALSE) fail();
  for (EGLDeviceEXT device : devices) {
    const char* extensions = query_string(device, EGL_EXTENSIONS);
    if (extensions == nullptr) continue;
    if (std::string_view(extensions).find("EGL_MESA_device_software") != std::string_view::npos) return device;
  }
  fail();
}

/// Shared by all contexts until the process ends.
EGLDisplay software_display() {
  static const EGLDisplay display = [] {
    const EGLDisplay opened = eglGetPlatformDisplay(EGL_PLATFORM_DEVICE_EXT, software_device(), nullptr);
    if (opened == EGL_NO_DISPLAY || eglInitialize(opened, nullptr, nullptr) == EGL_FALSE) fail();
    return opened;
  }();
  return display;
}

}  // namespace

std::string_view picture_library() { return "EGL"; }

GlContext::GlContext() {
  const EGLint attributes[] = {
      EGL_CONTEXT_MAJOR_VERSION,           4,       EGL_CONTEXT_MINOR_VERSION, 5, EGL_CONTEXT_OPENGL_PROFILE_MASK,
      EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
  eglBindAPI(EGL_OPENGL_API);
  context_ = eglCreateContext(software_display(), EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
  if (context_ == EGL_NO_CONTEXT) fail();
  make_current();
}

GlContext::~GlContext() {
  if (eglGetCurrentContext() == context_) release();
  eglDestroyContext(software_display(), context_);
}

void GlContext::make_current() {
  eglBindAPI(EGL_OPENGL_API);  // EGL keeps the current API per thread
  if (eglMakeCurrent(software_display(), EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_FALSE) fail();
}

void GlContext::release() { eglMakeCurrent(software_display(), EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT); }

GlContext::Function GlContext::proc_address(const char* name) { return eglGetProcAddress(name); }

}  // namespace swiftlet::sim
