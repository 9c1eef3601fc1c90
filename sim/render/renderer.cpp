// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/renderer.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>

#include "embedded/sim_render.hpp"
#include "sim/render/gl_context.hpp"
#include "sim/render/gl_objects_internal.hpp"
#include "sim/render/mark_painter.hpp"
#include "sim/render/overlay_painter.hpp"
#include "sim/render/shadow_painter.hpp"
#include "sim/render/vehicle_painter.hpp"
#include "sim/render/world_painter.hpp"
#include "swiftlet/sim/render/colors.hpp"

namespace swiftlet::sim {
namespace {

// [-] Samples per pixel (multisample anti-aliasing). Larger values smooth edges and take longer.
constexpr int kSamples = 4;
// [-] Recent views of the world that are compared with the next one: a repeated view belongs to a static camera. At
// least the number of cameras that are drawn in turn.
constexpr std::size_t kMaxSeenViews = 4;
// [-] Static cameras for which the drawn world is kept, to be reused in the next pictures. Larger values take memory.
constexpr std::size_t kMaxKeptSurfaces = 2;
// [-] Largest number of samples of a picture whose world is kept, 12 bytes each (color, normal, depth). Larger values
// take memory.
constexpr std::int64_t kMaxKeptSamples = 16'000'000;
// [-] Largest number of vehicles that leaves must not hide; length of u_watched in mesh.vert.
constexpr int kMaxWatched = 16;
// Radius around a watched vehicle that leaves must not hide: margin [m], and factor of its circumscribed radius. Larger
// values remove more leaves.
constexpr float kWatchedMargin_m = 0.4F, kWatchedRadii = 1.6F;
// [m] Diameter of cloud points when no fixed size in pixels is set.
constexpr float kCloudPoint_m = 0.07F;
// [-] Optical thickness of the haze over the diagonal of the world (see light.frag), and the diagonals [m] between
// which the haze adapts to it. A larger thickness fades distant surfaces more; 0.35 fades the far end by 19 %.
constexpr double kHazeAcross = 0.35, kMinHazeSize_m = 60.0, kMaxHazeSize_m = 1500.0;
// [m] Diagonal assumed for a world without surfaces.
constexpr double kEmptyWorldSize_m = 100.0;
// [-] Strength of the grid on the ground; at 0 it is invisible.
constexpr float kGridStrength = 0.75F;
// [m] Radius of ambient occlusion. Larger values darken corners more broadly.
constexpr float kOcclusionRadius_m = 0.9F;
// [-] Opacity of the parts of vehicles and of trails that the world occludes; at 0 they are invisible.
constexpr float kOccludedVehicle = 0.55F, kOccludedTrail = 0.4F;
// Color of the haze, sRGB.
const Eigen::Vector3f kHaze(0.83F, 0.88F, 0.92F);
const Eigen::Vector3f kWhite = Eigen::Vector3f::Ones();

std::vector<PointVertex> colored_points(std::span<const PictureCloud> clouds, const PictureStyle& style) {
  const CloudColors by = style.cloud;
  std::vector<PointVertex> points;
  HeightScale scale;
  if (by == CloudColors::kHeight) scale = style.heights ? *style.heights : height_scale_of(clouds);
  for (const PictureCloud& cloud : clouds) {
    for (std::size_t i = 0; i < cloud.points_world_m.size(); ++i) {
      const Eigen::Vector3f& p = cloud.points_world_m[i];
      Rgb color = Rgb::Constant(0.9F);
      if (by == CloudColors::kHeight) color = height_color((p.z() - scale.low_m) / (scale.high_m - scale.low_m));
      if (by == CloudColors::kVehicle) color = vehicle_color(cloud.vehicle);
      if (by == CloudColors::kLabel && i < cloud.surface_class.size()) color = class_color(cloud.surface_class[i]);
      // The square root spreads low intensities, since perceived brightness grows more slowly than intensity.
      if (by == CloudColors::kIntensity && i < cloud.intensity.size())
        color = viridis_like(std::sqrt(std::max(0.0F, cloud.intensity[i])));
      points.push_back({p, with_alpha(color, 1.0F)});
    }
  }
  return points;
}

/// Makes the OpenGL context current in the calling thread for one picture, since another thread may draw the next.
class CurrentContext {
 public:
  explicit CurrentContext(GlContext& context) : context_(context) { context_.make_current(); }
  ~CurrentContext() { context_.release(); }
  CurrentContext(const CurrentContext&) = delete;
  CurrentContext& operator=(const CurrentContext&) = delete;

 private:
  GlContext& context_;
};

}  // namespace

struct Renderer::Impl {
  GlContext context;
  GlFunctions gl = load_gl_functions();
  Program mesh_program{gl, "mesh", embedded::mesh_vert, embedded::mesh_frag};
  Program depth_program{gl, "depth", embedded::mesh_vert, embedded::depth_frag};
  Program ghost_program{gl, "ghost", embedded::mesh_vert, embedded::ghost_frag};
  Program occlusion_program{gl, "occlusion", embedded::screen_vert, embedded::occlusion_frag};
  Program soften_program{gl, "soften", embedded::screen_vert, embedded::soften_frag};
  Program smooth_program{gl, "smooth", embedded::screen_vert, embedded::smooth_frag};
  Program light_program{gl, "light", embedded::screen_vert, embedded::light_frag};
  WorldPainter world;
  VehiclePainter vehicles;
  MarkPainter marks{gl};
  std::vector<float> vehicle_radii_m;
  ShadowPainter shadows{gl, depth_program};
  GLuint empty_array = 0;  // vertex array without attributes, for triangles that cover the picture
  float haze_per_m = 0.001F;
  int samples = 0;  // per pixel of `sampled`
  Target sampled;   // drawing target, `samples` per pixel
  Target resolved;  // one sample per pixel
  Target openness;  // ambient light that occlusion leaves, and depth, at half resolution
  Target softened;  // openness, filtered to remove its sampling pattern

  Impl(const Scene& scene, std::span<const std::shared_ptr<const VehicleShape>> shapes)
      : world(gl, scene), vehicles(gl, shapes) {
    for (const auto& shape : shapes) vehicle_radii_m.push_back(shape->circumscribed_radius_m);
    gl.GenVertexArrays(1, &empty_array);
    gl.ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
    const double size_m = scene.bounds_m.isEmpty() ? kEmptyWorldSize_m : scene.bounds_m.diagonal().norm();
    haze_per_m = static_cast<float>(kHazeAcross / std::clamp(size_m, kMinHazeSize_m, kMaxHazeSize_m));
    context.release();
  }

  /// All inputs that determine the picture of the world without vehicles.
  struct WorldView {
    Eigen::Matrix4d clip_world = Eigen::Matrix4d::Zero();
    int width_px = 0, height_px = 0, samples = 0;
    float cut_m = 0.0F;
    bool cull = true, reduce = true, watching = false;
    bool operator==(const WorldView&) const = default;
  };
  /// World as drawn by a static camera.
  struct KeptSurfaces {
    WorldView view;
    Target surfaces;
  };
  std::vector<WorldView> seen;     // recent views, newest last
  std::vector<KeptSurfaces> kept;  // newest last

  void prepare_targets(const View& view, int wanted_samples);
  void copy(const Target& from, const Target& to) const;
  Target make_surfaces(int width, int height) const;
  void draw_world(const View& view, const PictureStyle& style, const Eigen::Matrix4f& clip_world);
  void set_watched(const PictureScene& picture, const PictureStyle& style) const;
  void draw_surfaces(const View& view, const PictureScene& picture, const PictureStyle& style);
  void bind_textures(std::initializer_list<GLuint> textures);
  void find_occlusion(const View& view);
  void light(const View& view, const PictureStyle& style);
  void draw_marks(const View& view, const PictureScene& picture, const PictureStyle& style);
  Image read_picture();
  void smooth_edges();
};

namespace {

Eigen::Vector3f forward_of(const View& view) {
  return -view.T_camera_world.block<1, 3>(2, 0).transpose().cast<float>();
}

Eigen::Vector3f axis_of(const View& view, int axis) {
  return view.T_camera_world.block<1, 3>(axis, 0).transpose().cast<float>();
}

DrawSelection select(const View& view, const PictureStyle& style, const Eigen::Matrix4f& clip_world) {
  DrawSelection selection;
  selection.frustum = frustum_of(clip_world);
  selection.eye_world_m = view.eye_world_m.cast<float>();
  selection.pixels_at_1m = static_cast<float>(view.pixels_per_m(1.0));
  selection.parallel = view.orthographic;
  selection.cull = style.cull;
  selection.reduce = style.reduce;
  selection.cut_m = cut_of(style);
  return selection;
}

/// Sets the uniforms that convert a pixel and its buffered depth into a point.
void set_depth_uniforms(const Program& program, const View& view) {
  const Eigen::Matrix4d camera_clip = view.clip_camera.inverse();
  const Eigen::Vector4d depth_m(-camera_clip(2, 2), -camera_clip(2, 3), camera_clip(3, 2), camera_clip(3, 3));
  program.set("u_depth_m", Eigen::Vector4f(depth_m.cast<float>()));
  program.set("u_spread", Eigen::Vector2f(1.0F / static_cast<float>(view.clip_camera(0, 0)),
                                          1.0F / static_cast<float>(view.clip_camera(1, 1))));
}

}  // namespace

Target Renderer::Impl::make_surfaces(int width, int height) const {
  return make_target(gl, width, height, {GL_RGBA8, GL_DEPTH_COMPONENT32F, samples, true});
}

void Renderer::Impl::prepare_targets(const View& view, int wanted_samples) {
  if (sampled.width == view.width_px && sampled.height == view.height_px && samples == wanted_samples) return;
  for (Target* target : {&sampled, &resolved, &openness, &softened}) delete_target(gl, *target);
  samples = wanted_samples;
  sampled = make_surfaces(view.width_px, view.height_px);
  resolved = make_target(gl, view.width_px, view.height_px, {GL_RGBA8, GL_DEPTH_COMPONENT32F, 1, true});
  openness = make_target(gl, (view.width_px + 1) / 2, (view.height_px + 1) / 2, {GL_RG32F, 0});
  softened = make_target(gl, openness.width, openness.height, {GL_RG32F, 0});
}

void Renderer::Impl::set_watched(const PictureScene& picture, const PictureStyle& style) const {
  int count = 0;
  for (const VehicleId vehicle : style.watched) {
    if (vehicle < 0 || vehicle >= std::ssize(picture.states) || vehicle >= std::ssize(vehicle_radii_m)) continue;
    if (count == kMaxWatched) break;
    const Eigen::Vector3f p = picture.states[vehicle].p_world_m.cast<float>();
    const float radius_m =
        kWatchedMargin_m + kWatchedRadii * vehicle_radii_m[vehicle] * static_cast<float>(style.vehicle_scale);
    mesh_program.set(("u_watched[" + std::to_string(count++) + "]").c_str(), with_alpha(p, radius_m));
  }
  mesh_program.set("u_num_watched", count);
}

/// Draws the world without vehicles. For a static camera it is drawn once and then copied into each picture.
void Renderer::Impl::draw_world(const View& view, const PictureStyle& style, const Eigen::Matrix4f& clip_world) {
  constexpr GLenum kBoth[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  const WorldView world_view{view.clip_world(), view.width_px, view.height_px, samples,
                             cut_of(style),     style.cull,    style.reduce,   !style.watched.empty()};
  const auto found =
      std::find_if(kept.begin(), kept.end(), [&](const KeptSurfaces& k) { return k.view == world_view; });
  if (found != kept.end()) {
    copy(found->surfaces, sampled);
    gl.BindFramebuffer(GL_FRAMEBUFFER, sampled.framebuffer);
    gl.DrawBuffers(2, kBoth);
    return;
  }
  world.draw(mesh_program, select(view, style, clip_world));
  if (world_view.watching) return;  // the omitted leaves change with the positions of the watched vehicles
  if (std::int64_t{samples} * view.width_px * view.height_px > kMaxKeptSamples) return;
  const bool again = std::find(seen.begin(), seen.end(), world_view) != seen.end();
  if (!again) {
    if (seen.size() >= kMaxSeenViews) seen.erase(seen.begin());
    seen.push_back(world_view);
    return;
  }
  if (kept.size() >= kMaxKeptSurfaces) {
    delete_target(gl, kept.front().surfaces);
    kept.erase(kept.begin());
  }
  kept.push_back({world_view, make_surfaces(sampled.width, sampled.height)});
  copy(sampled, kept.back().surfaces);
  gl.BindFramebuffer(GL_FRAMEBUFFER, sampled.framebuffer);
  gl.DrawBuffers(2, kBoth);
  mesh_program.use();
}

void Renderer::Impl::draw_surfaces(const View& view, const PictureScene& picture, const PictureStyle& style) {
  const Eigen::Matrix4f clip_world = view.clip_world().cast<float>();
  set_mesh_uniforms(mesh_program, clip_world, cut_of(style));
  mesh_program.set("u_eye_m", Eigen::Vector3f(view.eye_world_m.cast<float>()));
  mesh_program.set("u_forward", forward_of(view));
  mesh_program.set("u_parallel", view.orthographic ? 1.0F : 0.0F);
  mesh_program.set("u_grid", kGridStrength);
  set_watched(picture, style);
  if (!style.watched.empty()) gl.Enable(GL_CLIP_DISTANCE1);
  if (style.cut_above) gl.Enable(GL_CLIP_DISTANCE0);
  draw_world(view, style, clip_world);
  gl.Disable(GL_CLIP_DISTANCE0);
  gl.Disable(GL_CLIP_DISTANCE1);

  // Vehicles: first the parts occluded by the world, translucent and without depth, then the visible parts.
  constexpr GLenum kBoth[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  gl.DrawBuffers(1, kBoth);
  gl.Enable(GL_BLEND);
  gl.DepthMask(GL_FALSE);
  gl.DepthFunc(GL_LESS);
  set_mesh_uniforms(ghost_program, clip_world, kNoCut_m);
  for (std::size_t v = 0; v < picture.states.size(); ++v) {
    if (static_cast<VehicleId>(v) == style.hidden_vehicle) continue;
    ghost_program.set("u_color", with_alpha(vehicle_color(static_cast<VehicleId>(v)), kOccludedVehicle));
    vehicles.draw_one(v, picture.states[v], style.vehicle_scale);
  }
  gl.Disable(GL_BLEND);
  gl.DepthMask(GL_TRUE);
  gl.DepthFunc(GL_GEQUAL);
  gl.DrawBuffers(2, kBoth);
  mesh_program.use();
  mesh_program.set("u_num_watched", 0);
  mesh_program.set("u_leaf_growth", 0.0F);
  vehicles.draw(picture.states, style.vehicle_scale, style.hidden_vehicle);
}

/// Copies colors, normals and depth. If only the source has several samples per pixel, their colors and normals are
/// averaged.
void Renderer::Impl::copy(const Target& from, const Target& to) const {
  gl.BindFramebuffer(GL_READ_FRAMEBUFFER, from.framebuffer);
  gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, to.framebuffer);
  for (const GLenum color : {GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT0}) {
    gl.ReadBuffer(color);
    gl.DrawBuffer(color);
    gl.BlitFramebuffer(0, 0, from.width, from.height, 0, 0, to.width, to.height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  }
  gl.BlitFramebuffer(0, 0, from.width, from.height, 0, 0, to.width, to.height, GL_DEPTH_BUFFER_BIT, GL_NEAREST);
}

void Renderer::Impl::bind_textures(std::initializer_list<GLuint> textures) {
  GLenum unit = GL_TEXTURE0;
  for (const GLuint texture : textures) {
    gl.ActiveTexture(unit++);
    gl.BindTexture(GL_TEXTURE_2D, texture);
  }
}

/// Computes ambient occlusion in screen space, at half resolution, and filters it.
void Renderer::Impl::find_occlusion(const View& view) {
  gl.BindFramebuffer(GL_FRAMEBUFFER, openness.framebuffer);
  gl.Viewport(0, 0, openness.width, openness.height);
  gl.Disable(GL_DEPTH_TEST);
  bind_textures({resolved.depth, resolved.color, resolved.color2});
  occlusion_program.use();
  occlusion_program.set("u_depth", 0);
  occlusion_program.set("u_base", 1);
  occlusion_program.set("u_normal", 2);
  set_depth_uniforms(occlusion_program, view);
  occlusion_program.set("u_camera_world", Eigen::Matrix4f(view.T_camera_world.cast<float>()));
  occlusion_program.set("u_radius_m", kOcclusionRadius_m);
  occlusion_program.set("u_pixels_at_1m", static_cast<float>(view.pixels_per_m(1.0)));
  occlusion_program.set("u_parallel", view.orthographic ? 1.0F : 0.0F);
  gl.BindVertexArray(empty_array);
  gl.DrawArrays(GL_TRIANGLES, 0, 3);

  gl.BindFramebuffer(GL_FRAMEBUFFER, softened.framebuffer);
  bind_textures({openness.color});
  soften_program.use();
  soften_program.set("u_open", 0);
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
}

/// Shades the picture, and keeps the depth of each sample, so that marks drawn later are occluded correctly.
void Renderer::Impl::light(const View& view, const PictureStyle& style) {
  const Shadow& shadow = shadows.of_world(style);
  const Shadow& vehicle_shadow = shadows.of_vehicles();
  gl.BindFramebuffer(GL_FRAMEBUFFER, sampled.framebuffer);
  gl.DrawBuffer(GL_COLOR_ATTACHMENT0);
  gl.Viewport(0, 0, view.width_px, view.height_px);
  bind_textures({resolved.color, resolved.color2, resolved.depth, softened.color, shadow.target.depth,
                 vehicle_shadow.target.depth});
  light_program.use();
  int unit = 0;
  for (const char* name : {"u_base", "u_normal", "u_depth", "u_open", "u_shadow", "u_vehicle_shadow"}) {
    light_program.set(name, unit++);
  }
  set_depth_uniforms(light_program, view);
  light_program.set("u_right", axis_of(view, 0));
  light_program.set("u_up", axis_of(view, 1));
  light_program.set("u_eye_m", Eigen::Vector3f(view.eye_world_m.cast<float>()));
  light_program.set("u_forward", forward_of(view));
  light_program.set("u_parallel", view.orthographic ? 1.0F : 0.0F);
  light_program.set("u_sun", sun_of(style));
  light_program.set("u_haze_per_m", haze_per_m);
  light_program.set("u_haze_color", style.white ? kWhite : kHaze);
  light_program.set("u_white", style.white ? 1.0F : 0.0F);
  light_program.set("u_shadow_world", shadow.texture_world);
  light_program.set("u_vehicle_shadow_world", vehicle_shadow.texture_world);
  light_program.set("u_shadow_texel_m", shadow.texel_m);
  gl.BindVertexArray(empty_array);
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
  gl.Enable(GL_DEPTH_TEST);
}

void Renderer::Impl::draw_marks(const View& view, const PictureScene& picture, const PictureStyle& style) {
  gl.DepthFunc(GL_GEQUAL);
  gl.Enable(GL_CLIP_DISTANCE0);
  if (style.cloud != CloudColors::kNone) {
    gl.DepthMask(GL_TRUE);
    const PointSize size = style.point_px > 0.0F ? PointSize{0.0F, style.point_px} : PointSize{kCloudPoint_m};
    marks.draw_points(view, colored_points(picture.clouds, style), size, cut_of(style));
  }

  gl.Enable(GL_BLEND);
  gl.DepthMask(GL_FALSE);
  // Opaque overlays first, so that translucent ones are blended over them.
  for (const bool opaque : {true, false}) {
    for (const Overlay& overlay : picture.overlays) {
      if (is_chosen(overlay, style.overlays) && is_opaque(overlay) == opaque)
        draw_overlay(gl, marks, view, overlay, style);
    }
  }
  gl.Disable(GL_CLIP_DISTANCE0);

  if (style.trails) {
    std::vector<ClipVertex> outline;
    std::vector<ClipVertex> ribbon;
    append_trails(view, picture, style.line_scale, outline, ribbon);
    gl.DepthFunc(GL_LESS);  // depth is reversed: draws the occluded parts
    marks.draw_clip(ribbon, kOccludedTrail);
    gl.DepthFunc(GL_GEQUAL);
    marks.draw_clip(outline, 1.0F);
    marks.draw_clip(ribbon, 1.0F);
  }
  std::vector<ClipVertex> discs;
  vehicles.append_discs(view, picture.states, style.vehicle_scale, style.hidden_vehicle, discs);
  marks.draw_clip(discs, 1.0F);
  gl.Disable(GL_BLEND);
}

/// Smooths edges in a picture with one sample per pixel, instead of multisampling.
void Renderer::Impl::smooth_edges() {
  gl.BindFramebuffer(GL_FRAMEBUFFER, resolved.framebuffer);
  gl.DrawBuffer(GL_COLOR_ATTACHMENT0);
  gl.Disable(GL_DEPTH_TEST);
  bind_textures({sampled.color});
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  smooth_program.use();
  smooth_program.set("u_picture", 0);
  gl.BindVertexArray(empty_array);
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
}

Image Renderer::Impl::read_picture() {
  const int width = sampled.width;
  const int height = sampled.height;
  if (samples > 1) {
    gl.BindFramebuffer(GL_READ_FRAMEBUFFER, sampled.framebuffer);
    gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved.framebuffer);
    gl.ReadBuffer(GL_COLOR_ATTACHMENT0);
    gl.DrawBuffer(GL_COLOR_ATTACHMENT0);
    gl.BlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  } else {
    smooth_edges();
  }
  gl.BindFramebuffer(GL_READ_FRAMEBUFFER, resolved.framebuffer);
  gl.ReadBuffer(GL_COLOR_ATTACHMENT0);
  std::vector<std::uint8_t> rgba_bottom_up(static_cast<std::size_t>(width) * height * 4);
  gl.ReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rgba_bottom_up.data());

  Image image;
  image.width = width;
  image.height = height;
  image.rgb.resize(static_cast<std::size_t>(width) * height * 3);
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* from = rgba_bottom_up.data() + static_cast<std::size_t>(height - 1 - y) * width * 4;
    std::uint8_t* to = image.pixel(0, y);
    for (int x = 0; x < width; ++x, from += 4, to += 3) std::copy(from, from + 3, to);
  }
  return image;
}

Renderer::Renderer(const Scene& scene, std::span<const std::shared_ptr<const VehicleShape>> vehicle_shapes)
    : impl_(std::make_unique<Impl>(scene, vehicle_shapes)) {}
Renderer::~Renderer() = default;

Image Renderer::draw(const View& view, const PictureScene& picture, const PictureStyle& style) {
  Impl& r = *impl_;
  const CurrentContext current(r.context);
  r.prepare_targets(view, style.quick ? 1 : kSamples);
  r.gl.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  r.gl.Disable(GL_BLEND);
  r.shadows.draw_world(r.world, style);
  r.shadows.draw_vehicles(r.vehicles, r.vehicle_radii_m, picture, style);

  r.gl.BindFramebuffer(GL_FRAMEBUFFER, r.sampled.framebuffer);
  constexpr GLenum kBoth[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  r.gl.DrawBuffers(2, kBoth);
  r.gl.Viewport(0, 0, view.width_px, view.height_px);
  r.gl.ClearColor(0.0F, 0.0F, 0.0F, 0.0F);
  r.gl.ClearDepth(0.0);
  r.gl.DepthMask(GL_TRUE);
  r.gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  r.gl.Enable(GL_DEPTH_TEST);
  r.gl.DepthFunc(GL_GEQUAL);
  r.draw_surfaces(view, picture, style);
  r.copy(r.sampled, r.resolved);
  r.find_occlusion(view);
  r.light(view, style);
  r.draw_marks(view, picture, style);
  return r.read_picture();
}

DepthImage Renderer::draw_depth(const View& view, const PictureScene& picture, const PictureStyle& style) {
  Impl& r = *impl_;
  const CurrentContext current(r.context);
  r.prepare_targets(view, r.samples > 0 ? r.samples : kSamples);
  const Eigen::Matrix4f clip_world = view.clip_world().cast<float>();
  r.gl.Disable(GL_BLEND);
  r.gl.BindFramebuffer(GL_FRAMEBUFFER, r.resolved.framebuffer);
  r.gl.Viewport(0, 0, view.width_px, view.height_px);
  r.gl.ClearDepth(0.0);
  r.gl.DepthMask(GL_TRUE);
  r.gl.Clear(GL_DEPTH_BUFFER_BIT);
  r.gl.Enable(GL_DEPTH_TEST);
  r.gl.DepthFunc(GL_GEQUAL);
  set_mesh_uniforms(r.depth_program, clip_world, cut_of(style));
  r.gl.Enable(GL_CLIP_DISTANCE0);
  r.world.draw(r.depth_program, select(view, style, clip_world));
  r.gl.Disable(GL_CLIP_DISTANCE0);
  set_mesh_uniforms(r.depth_program, clip_world, kNoCut_m);
  r.vehicles.draw(picture.states, style.vehicle_scale, style.hidden_vehicle);

  std::vector<float> bottom_up(static_cast<std::size_t>(view.width_px) * view.height_px);
  r.gl.ReadPixels(0, 0, view.width_px, view.height_px, GL_DEPTH_COMPONENT, GL_FLOAT, bottom_up.data());
  DepthImage image{view.width_px, view.height_px, {}};
  image.depth_m.resize(bottom_up.size());
  const Eigen::Matrix4d camera_clip = view.clip_camera.inverse();
  for (int y = 0; y < view.height_px; ++y) {
    for (int x = 0; x < view.width_px; ++x) {
      const double depth = bottom_up[static_cast<std::size_t>(view.height_px - 1 - y) * view.width_px + x];
      const double z = camera_clip(2, 2) * depth + camera_clip(2, 3);
      const double w = camera_clip(3, 2) * depth + camera_clip(3, 3);
      image.depth_m[static_cast<std::size_t>(y) * view.width_px + x] = depth > 0.0 ? static_cast<float>(-z / w) : 0.0F;
    }
  }
  return image;
}

}  // namespace swiftlet::sim
