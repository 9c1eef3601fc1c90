// SPDX-License-Identifier: BSD-3-Clause
#include <GL/osmesa.h>

#include <stdexcept>

#include "sim/render/gl_context.hpp"
#include "swiftlet/sim/render/render_config.hpp"

namespace swiftlet::sim {
namespace {

constexpr const char* kNoContext =
    "pictures need an OpenGL 4.5 core context, which OSMesa could not create "
    "(package libosmesa6, built with LLVM); remove `snapshots` from the scenario to run without pictures";

// [px] Width and height of the default framebuffer, GlContext::buffer_, which OSMesa requires.
constexpr int kBufferSize_px = 16;

}  // namespace

std::string_view picture_library() { return "OSMesa"; }

GlContext::GlContext() {
  const int attributes[] = {OSMESA_FORMAT,
                            OSMESA_RGBA,
                            OSMESA_PROFILE,
                            OSMESA_CORE_PROFILE,
                            OSMESA_CONTEXT_MAJOR_VERSION,
                            4,
                            OSMESA_CONTEXT_MINOR_VERSION,
                            5,
                            0};
  context_ = OSMesaCreateContextAttribs(attributes, nullptr);
  if (context_ == nullptr) throw std::runtime_error(kNoContext);
  make_current();
}

GlContext::~GlContext() { OSMesaDestroyContext(static_cast<OSMesaContext>(context_)); }

void GlContext::make_current() {
  if (OSMesaGetCurrentContext() == context_) return;
  if (OSMesaMakeCurrent(static_cast<OSMesaContext>(context_), buffer_, GL_UNSIGNED_BYTE, kBufferSize_px,
                        kBufferSize_px) == GL_FALSE) {
    throw std::runtime_error(kNoContext);
  }
}

void GlContext::release() { OSMesaMakeCurrent(nullptr, nullptr, 0, 0, 0); }

GlContext::Function GlContext::proc_address(const char* name) { return OSMesaGetProcAddress(name); }

}  // namespace swiftlet::sim
