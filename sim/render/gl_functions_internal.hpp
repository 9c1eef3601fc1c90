// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <GL/glcorearb.h>

namespace swiftlet::sim {

// Type and name, without the leading "gl".
#define SWIFTLET_GL_FUNCTIONS(X)                                                                       \
  X(PFNGLACTIVETEXTUREPROC, ActiveTexture)                                                             \
  X(PFNGLATTACHSHADERPROC, AttachShader)                                                               \
  X(PFNGLBINDBUFFERPROC, BindBuffer)                                                                   \
  X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)                                                         \
  X(PFNGLBINDTEXTUREPROC, BindTexture)                                                                 \
  X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)                                                         \
  X(PFNGLBLENDFUNCPROC, BlendFunc)                                                                     \
  X(PFNGLBLITFRAMEBUFFERPROC, BlitFramebuffer)                                                         \
  X(PFNGLBUFFERDATAPROC, BufferData)                                                                   \
  X(PFNGLCHECKFRAMEBUFFERSTATUSPROC, CheckFramebufferStatus)                                           \
  X(PFNGLCLEARPROC, Clear)                                                                             \
  X(PFNGLCLEARCOLORPROC, ClearColor)                                                                   \
  X(PFNGLCLEARDEPTHPROC, ClearDepth)                                                                   \
  X(PFNGLCLIPCONTROLPROC, ClipControl)                                                                 \
  X(PFNGLCOLORMASKPROC, ColorMask)                                                                     \
  X(PFNGLCOMPILESHADERPROC, CompileShader)                                                             \
  X(PFNGLCREATEPROGRAMPROC, CreateProgram)                                                             \
  X(PFNGLCREATESHADERPROC, CreateShader)                                                               \
  X(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers)                                                   \
  X(PFNGLDELETESHADERPROC, DeleteShader)                                                               \
  X(PFNGLDELETETEXTURESPROC, DeleteTextures)                                                           \
  X(PFNGLDEPTHFUNCPROC, DepthFunc)                                                                     \
  X(PFNGLDEPTHMASKPROC, DepthMask)                                                                     \
  X(PFNGLDISABLEPROC, Disable)                                                                         \
  X(PFNGLDRAWARRAYSPROC, DrawArrays)                                                                   \
  X(PFNGLDRAWARRAYSINSTANCEDPROC, DrawArraysInstanced)                                                 \
  X(PFNGLDRAWBUFFERPROC, DrawBuffer)                                                                   \
  X(PFNGLDRAWBUFFERSPROC, DrawBuffers)                                                                 \
  X(PFNGLDRAWELEMENTSPROC, DrawElements)                                                               \
  X(PFNGLDRAWELEMENTSINSTANCEDBASEVERTEXBASEINSTANCEPROC, DrawElementsInstancedBaseVertexBaseInstance) \
  X(PFNGLENABLEPROC, Enable)                                                                           \
  X(PFNGLENABLEVERTEXATTRIBARRAYPROC, EnableVertexAttribArray)                                         \
  X(PFNGLFRAMEBUFFERTEXTURE2DPROC, FramebufferTexture2D)                                               \
  X(PFNGLGENBUFFERSPROC, GenBuffers)                                                                   \
  X(PFNGLGENFRAMEBUFFERSPROC, GenFramebuffers)                                                         \
  X(PFNGLGENTEXTURESPROC, GenTextures)                                                                 \
  X(PFNGLGENVERTEXARRAYSPROC, GenVertexArrays)                                                         \
  X(PFNGLGETERRORPROC, GetError)                                                                       \
  X(PFNGLGETPROGRAMIVPROC, GetProgramiv)                                                               \
  X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)                                                     \
  X(PFNGLGETSHADERIVPROC, GetShaderiv)                                                                 \
  X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)                                                       \
  X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation)                                                   \
  X(PFNGLLINKPROGRAMPROC, LinkProgram)                                                                 \
  X(PFNGLPIXELSTOREIPROC, PixelStorei)                                                                 \
  X(PFNGLPOLYGONOFFSETPROC, PolygonOffset)                                                             \
  X(PFNGLREADBUFFERPROC, ReadBuffer)                                                                   \
  X(PFNGLREADPIXELSPROC, ReadPixels)                                                                   \
  X(PFNGLSHADERSOURCEPROC, ShaderSource)                                                               \
  X(PFNGLTEXIMAGE2DPROC, TexImage2D)                                                                   \
  X(PFNGLTEXIMAGE2DMULTISAMPLEPROC, TexImage2DMultisample)                                             \
  X(PFNGLTEXPARAMETERIPROC, TexParameteri)                                                             \
  X(PFNGLTEXPARAMETERFVPROC, TexParameterfv)                                                           \
  X(PFNGLUNIFORM1FPROC, Uniform1f)                                                                     \
  X(PFNGLUNIFORM1IPROC, Uniform1i)                                                                     \
  X(PFNGLUNIFORM2FPROC, Uniform2f)                                                                     \
  X(PFNGLUNIFORM3FPROC, Uniform3f)                                                                     \
  X(PFNGLUNIFORM4FPROC, Uniform4f)                                                                     \
  X(PFNGLUNIFORMMATRIX4FVPROC, UniformMatrix4fv)                                                       \
  X(PFNGLUSEPROGRAMPROC, UseProgram)                                                                   \
  X(PFNGLVERTEXATTRIB4FPROC, VertexAttrib4f)                                                           \
  X(PFNGLVERTEXATTRIBDIVISORPROC, VertexAttribDivisor)                                                 \
  X(PFNGLVERTEXATTRIBPOINTERPROC, VertexAttribPointer)                                                 \
  X(PFNGLVIEWPORTPROC, Viewport)

/// The OpenGL functions used: gl.Enable(GL_DEPTH_TEST). Loaded from the context instead of linked.
struct GlFunctions {
#define SWIFTLET_GL_DECLARE(type, name) type name = nullptr;
  SWIFTLET_GL_FUNCTIONS(SWIFTLET_GL_DECLARE)
#undef SWIFTLET_GL_DECLARE
};

/// Loads all of them from the current context; throws std::runtime_error when one is missing.
GlFunctions load_gl_functions();

}  // namespace swiftlet::sim
