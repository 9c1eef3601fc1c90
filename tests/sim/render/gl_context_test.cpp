// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/gl_context.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <thread>
#include <vector>

#include "sim/render/gl_objects_internal.hpp"
#include "swiftlet/sim/render/render_config.hpp"

namespace swiftlet::sim {
namespace {

using Pixel = std::array<std::uint8_t, 4>;

template <class Function>
Function gl_function(const char* name) {
  return reinterpret_cast<Function>(GlContext::proc_address(name));
}

GLint integer(GLenum name) {
  GLint value = 0;
  gl_function<PFNGLGETINTEGERVPROC>("glGetIntegerv")(name, &value);
  return value;
}

/// Clears a new target of the current context to a color and reads a corner of it.
Pixel cleared_to(float red, float green, float blue) {
  const GlFunctions gl = load_gl_functions();
  const Target target = make_target(gl, 40, 30, {GL_RGBA8});
  gl.BindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  gl.ClearColor(red, green, blue, 1.0F);
  gl.Clear(GL_COLOR_BUFFER_BIT);
  Pixel pixel = {};
  gl.ReadPixels(39, 29, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, pixel.data());
  return pixel;
}

TEST(GlContext, HasTheCoreProfileOf45) {
  const GlContext context;
  EXPECT_GE(10 * integer(GL_MAJOR_VERSION) + integer(GL_MINOR_VERSION), 45);
  EXPECT_TRUE(integer(GL_CONTEXT_PROFILE_MASK) & GL_CONTEXT_CORE_PROFILE_BIT);
}

TEST(GlContext, DrawsInSoftware) {
  const GlContext context;
  const auto* renderer = gl_function<PFNGLGETSTRINGPROC>("glGetString")(GL_RENDERER);
  ASSERT_NE(renderer, nullptr);
  EXPECT_THAT(reinterpret_cast<const char*>(renderer), ::testing::HasSubstr("llvmpipe")) << picture_library();
}

TEST(GlContext, IsHandedFromThreadToThread) {
  GlContext context;
  context.release();
  for (int i = 0; i < 3; ++i) {
    Pixel pixel = {};
    std::thread([&] {
      context.make_current();
      pixel = cleared_to(0.0F, 1.0F, 0.2F);
      context.release();
    }).join();
    EXPECT_EQ(pixel, (Pixel{0, 255, 51, 255}));
  }
  context.make_current();
  EXPECT_EQ(cleared_to(1.0F, 0.0F, 0.0F), (Pixel{255, 0, 0, 255}));
}

TEST(GlContext, DrawsInSeveralThreadsConcurrently) {
  std::array<Pixel, 4> pixels = {};
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    threads.emplace_back([&pixels, i] {
      const GlContext context;
      for (int k = 0; k < 20; ++k) pixels[i] = cleared_to(0.2F * static_cast<float>(i), 0.0F, 1.0F);
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    EXPECT_EQ(pixels[i], (Pixel{static_cast<std::uint8_t>(51 * i), 0, 255, 255}));
  }
}

TEST(GlContext, StaysCurrentWhenAnotherIsDestroyed) {
  GlContext context;
  { const GlContext another; }
  context.make_current();
  EXPECT_EQ(cleared_to(0.6F, 0.6F, 0.0F), (Pixel{153, 153, 0, 255}));
}

}  // namespace
}  // namespace swiftlet::sim
