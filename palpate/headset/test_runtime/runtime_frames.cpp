// The test runtime's swapchains and frames.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <type_traits>
#include <utility>

#include "runtime.h"

#ifndef GL_SRGB8_ALPHA8
#define GL_SRGB8_ALPHA8 0x8C43
#endif

namespace palpate::headset {
namespace {

Placed of_pose(const XrPosef& pose) {
  return {{pose.orientation.w, pose.orientation.x, pose.orientation.y, pose.orientation.z},
          {pose.position.x, pose.position.y, pose.position.z}};
}

}  // namespace

bool OpenGl::load(PFNEGLGETPROCADDRESSPROC find) {
  if (find == nullptr) return false;
  const auto get_into = [find](const char* name, auto& function) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(find(name));
    return function != nullptr;
  };
  return get_into("glGenTextures", gen_textures) && get_into("glDeleteTextures", delete_textures) &&
         get_into("glBindTexture", bind_texture) && get_into("glTexImage2D", image) &&
         get_into("glGetTexImage", read_image) && get_into("glGetIntegerv", get) &&
         get_into("glPixelStorei", pixel_store);
}

XrResult Runtime::make_swapchain(const XrSwapchainCreateInfo& info, XrSwapchain* swapchain) {
  const std::lock_guard lock(mutex_);
  if (info.format != GL_SRGB8_ALPHA8 && info.format != GL_RGBA8) return XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED;
  if (info.width == 0 || info.height == 0 || info.faceCount != 1 || info.arraySize != 1 ||
      info.mipCount != 1 || info.sampleCount != 1)
    return XR_ERROR_VALIDATION_FAILURE;
  Swapchain made;
  made.info = info;
  GLint bound = 0;
  gl_.get(GL_TEXTURE_BINDING_2D, &bound);
  gl_.gen_textures(static_cast<GLsizei>(made.textures.size()), made.textures.data());
  for (const GLuint texture : made.textures) {
    gl_.bind_texture(GL_TEXTURE_2D, texture);
    gl_.image(GL_TEXTURE_2D, 0, static_cast<GLint>(info.format), static_cast<GLsizei>(info.width),
              static_cast<GLsizei>(info.height), 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  }
  gl_.bind_texture(GL_TEXTURE_2D, static_cast<GLuint>(bound));
  *swapchain = reinterpret_cast<XrSwapchain>(++handles_);
  swapchains_[handles_] = made;
  return XR_SUCCESS;
}

XrResult Runtime::end_swapchain(XrSwapchain swapchain) {
  const std::lock_guard lock(mutex_);
  const auto at = swapchains_.find(reinterpret_cast<std::uint64_t>(swapchain));
  if (at == swapchains_.end()) return XR_ERROR_HANDLE_INVALID;
  gl_.delete_textures(static_cast<GLsizei>(at->second.textures.size()), at->second.textures.data());
  swapchains_.erase(at);
  return XR_SUCCESS;
}

XrResult Runtime::images(XrSwapchain swapchain, std::uint32_t capacity, std::uint32_t* count,
                         XrSwapchainImageBaseHeader* images) {
  const std::lock_guard lock(mutex_);
  const auto at = swapchains_.find(reinterpret_cast<std::uint64_t>(swapchain));
  if (at == swapchains_.end()) return XR_ERROR_HANDLE_INVALID;
  *count = static_cast<std::uint32_t>(at->second.textures.size());
  if (capacity == 0) return XR_SUCCESS;
  if (capacity < *count) return XR_ERROR_SIZE_INSUFFICIENT;
  auto* out = reinterpret_cast<XrSwapchainImageOpenGLKHR*>(images);
  for (std::uint32_t i = 0; i < *count; ++i) {
    if (out[i].type != XR_TYPE_SWAPCHAIN_IMAGE_OPENGL_KHR) return XR_ERROR_VALIDATION_FAILURE;
    out[i].image = at->second.textures[i];
  }
  return XR_SUCCESS;
}

XrResult Runtime::acquire(XrSwapchain swapchain, std::uint32_t* index) {
  const std::lock_guard lock(mutex_);
  const auto at = swapchains_.find(reinterpret_cast<std::uint64_t>(swapchain));
  if (at == swapchains_.end()) return XR_ERROR_HANDLE_INVALID;
  Swapchain& chain = at->second;
  if (chain.acquired.size() == chain.textures.size()) return XR_ERROR_CALL_ORDER_INVALID;
  *index = chain.next;
  chain.next = (chain.next + 1) % static_cast<std::uint32_t>(chain.textures.size());
  chain.acquired.push_back(*index);
  return XR_SUCCESS;
}

XrResult Runtime::wait_image(XrSwapchain swapchain) {
  const std::lock_guard lock(mutex_);
  const auto at = swapchains_.find(reinterpret_cast<std::uint64_t>(swapchain));
  if (at == swapchains_.end()) return XR_ERROR_HANDLE_INVALID;
  if (at->second.acquired.empty() || at->second.waited) return XR_ERROR_CALL_ORDER_INVALID;
  at->second.waited = true;
  return XR_SUCCESS;
}

XrResult Runtime::release(XrSwapchain swapchain) {
  const std::lock_guard lock(mutex_);
  const auto at = swapchains_.find(reinterpret_cast<std::uint64_t>(swapchain));
  if (at == swapchains_.end()) return XR_ERROR_HANDLE_INVALID;
  Swapchain& chain = at->second;
  if (!chain.waited) return XR_ERROR_CALL_ORDER_INVALID;
  auto image = std::make_shared<LayerImage>();
  image->width = static_cast<int>(chain.info.width);
  image->height = static_cast<int>(chain.info.height);
  image->encoded = chain.info.format == GL_SRGB8_ALPHA8;
  image->rgba.resize(static_cast<std::size_t>(chain.info.width) * chain.info.height * 4);
  GLint bound = 0, alignment = 4;
  gl_.get(GL_TEXTURE_BINDING_2D, &bound);
  gl_.get(GL_PACK_ALIGNMENT, &alignment);
  gl_.pixel_store(GL_PACK_ALIGNMENT, 1);
  gl_.bind_texture(GL_TEXTURE_2D, chain.textures[chain.acquired.front()]);
  gl_.read_image(GL_TEXTURE_2D, 0, GL_RGBA, GL_UNSIGNED_BYTE, image->rgba.data());
  gl_.bind_texture(GL_TEXTURE_2D, static_cast<GLuint>(bound));
  gl_.pixel_store(GL_PACK_ALIGNMENT, alignment);
  chain.newest = std::move(image);
  chain.acquired.pop_front();
  chain.waited = false;
  ++counts_.uploads;
  return XR_SUCCESS;
}

XrResult Runtime::begin_session() {
  const std::lock_guard lock(mutex_);
  if (running_) return XR_ERROR_SESSION_RUNNING;
  running_ = true;
  wait_done_ = begun_ = false;
  put_session(XR_SESSION_STATE_SYNCHRONIZED);
  put_session(XR_SESSION_STATE_VISIBLE);
  put_session(XR_SESSION_STATE_FOCUSED);
  return XR_SUCCESS;
}

XrResult Runtime::end_session() {
  const std::lock_guard lock(mutex_);
  if (!running_) return XR_ERROR_SESSION_NOT_RUNNING;
  if (worn_) return XR_ERROR_SESSION_NOT_STOPPING;
  running_ = false;
  layers_.clear();
  put_session(XR_SESSION_STATE_IDLE);
  return XR_SUCCESS;
}

XrResult Runtime::wait_frame(XrFrameState& state) {
  std::unique_lock lock(mutex_);
  if (!running_) return XR_ERROR_SESSION_NOT_RUNNING;
  const auto period = static_cast<std::int64_t>(std::llround(1e9 / display_.rate_hz));
  counts_.waiting = true;
  changed_.notify_all();
  obey_file();
  while (!virtual_time_ && hung_ && !gone_) {
    changed_.wait_for(lock, std::chrono::milliseconds(10));
    obey_file();
  }
  // Told when by refresh(); or at every period of real time. A change of worn has to be noticed by the application.
  changed_.wait(lock, [this] {
    return gone_ || !worn_ || (!hung_ && (!virtual_time_ || frame_asked_ > frame_waited_));
  });
  if (!virtual_time_ && !gone_) {
    const std::int64_t due = std::max(last_real_ns_ + period, now_locked());
    changed_.wait_for(lock, std::chrono::nanoseconds(due - now_locked()), [this] { return gone_; });
    last_real_ns_ = due;
  }
  counts_.waiting = false;
  if (gone_) return XR_ERROR_INSTANCE_LOST;
  frame_waited_ = frame_asked_;
  wait_done_ = true;
  state.predictedDisplayTime =
      now_locked() + static_cast<std::int64_t>(display_.ahead_periods * static_cast<double>(period)) +
      kXrTimeAhead_ns;
  state.predictedDisplayPeriod = period;
  state.shouldRender = worn_ ? XR_TRUE : XR_FALSE;
  return XR_SUCCESS;
}

XrResult Runtime::begin_frame() {
  const std::lock_guard lock(mutex_);
  if (!running_) return XR_ERROR_SESSION_NOT_RUNNING;
  if (!wait_done_) return XR_ERROR_CALL_ORDER_INVALID;
  wait_done_ = false;
  const bool before = std::exchange(begun_, true);
  return before ? XR_FRAME_DISCARDED : XR_SUCCESS;
}

XrResult Runtime::part_of(const XrSwapchainSubImage& sub, LayerPart& part) const {
  const auto at = swapchains_.find(reinterpret_cast<std::uint64_t>(sub.swapchain));
  if (at == swapchains_.end()) return XR_ERROR_HANDLE_INVALID;
  if (at->second.newest == nullptr) return XR_ERROR_LAYER_INVALID;  // never released
  const auto& rect = sub.imageRect;
  const LayerImage& image = *at->second.newest;
  if (rect.offset.x < 0 || rect.offset.y < 0 || rect.extent.width <= 0 || rect.extent.height <= 0 ||
      rect.offset.x + rect.extent.width > image.width || rect.offset.y + rect.extent.height > image.height)
    return XR_ERROR_SWAPCHAIN_RECT_INVALID;
  part = {at->second.newest, rect.offset.x, rect.offset.y, rect.extent.width, rect.extent.height};
  return XR_SUCCESS;
}

XrResult Runtime::layer_of(const XrCompositionLayerBaseHeader& header, std::int64_t display_ns,
                           Layer& layer) const {
  const auto space = spaces_.find(reinterpret_cast<std::uint64_t>(header.space));
  if (space == spaces_.end()) return XR_ERROR_HANDLE_INVALID;
  layer.in_view = space->second == XR_REFERENCE_SPACE_TYPE_VIEW;
  layer.blend = (header.layerFlags & XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT) != 0;
  // Spaces are those of the moment at which the frame is seen.
  const auto in_room = [&](const XrPosef& pose) {
    return layer.in_view ? of_pose(pose) : chained(local_at(display_ns), of_pose(pose));
  };
  if (header.type == XR_TYPE_COMPOSITION_LAYER_QUAD) {
    const auto& quad = reinterpret_cast<const XrCompositionLayerQuad&>(header);
    layer.kind = Layer::Kind::quad;
    layer.left = quad.eyeVisibility != XR_EYE_VISIBILITY_RIGHT;
    layer.right = quad.eyeVisibility != XR_EYE_VISIBILITY_LEFT;
    layer.place = in_room(quad.pose);
    layer.width = quad.size.width;
    layer.height = quad.size.height;
    return part_of(quad.subImage, layer.part);
  }
  if (header.type != XR_TYPE_COMPOSITION_LAYER_PROJECTION) return XR_ERROR_LAYER_INVALID;
  const auto& projection = reinterpret_cast<const XrCompositionLayerProjection&>(header);
  layer.kind = Layer::Kind::projection;
  if (projection.viewCount != layer.views.size()) return XR_ERROR_VALIDATION_FAILURE;
  for (std::size_t i = 0; i < layer.views.size(); ++i) {
    const XrCompositionLayerProjectionView& from = projection.views[i];
    Layer::View& view = layer.views[i];
    view.place = in_room(from.pose);
    view.left = std::tan(from.fov.angleLeft);
    view.right = std::tan(from.fov.angleRight);
    view.up = std::tan(from.fov.angleUp);
    view.down = std::tan(from.fov.angleDown);
    if (const XrResult result = part_of(from.subImage, view.part); result != XR_SUCCESS) return result;
  }
  return XR_SUCCESS;
}

XrResult Runtime::end_frame(const XrFrameEndInfo& info) {
  const std::lock_guard lock(mutex_);
  if (!running_) return XR_ERROR_SESSION_NOT_RUNNING;
  if (!begun_) return XR_ERROR_CALL_ORDER_INVALID;
  if (info.displayTime <= 0) return XR_ERROR_TIME_INVALID;
  if (info.environmentBlendMode != XR_ENVIRONMENT_BLEND_MODE_OPAQUE)
    return XR_ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED;
  begun_ = false;
  const std::int64_t display_ns = info.displayTime - kXrTimeAhead_ns;
  std::vector<Layer> layers(info.layerCount);
  for (std::uint32_t i = 0; i < info.layerCount; ++i)
    if (const XrResult result = layer_of(*info.layers[i], display_ns, layers[i]); result != XR_SUCCESS)
      return result;
  layers_ = std::move(layers);
  ++counts_.frames;
  counts_.with_layers += layers_.empty() ? 0 : 1;
  counts_.quads = static_cast<std::uint64_t>(std::count_if(
      layers_.begin(), layers_.end(), [](const Layer& one) { return one.kind == Layer::Kind::quad; }));
  counts_.display_ns = display_ns;
  frame_ended_ = frame_waited_;
  changed_.notify_all();
  return XR_SUCCESS;
}

}  // namespace palpate::headset
