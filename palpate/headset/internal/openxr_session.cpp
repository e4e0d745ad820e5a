#include "palpate/headset/internal/openxr_session.h"

#include <utility>

namespace palpate::headset {
namespace {

constexpr XrSpaceLocationFlags kPoseKnown =
    XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT;

Expected<XrSpace> make_space(XrSession session, XrReferenceSpaceType type) {
  XrReferenceSpaceCreateInfo info{};
  info.type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO;
  info.referenceSpaceType = type;
  info.poseInReferenceSpace.orientation.w = 1.0F;
  XrSpace space = XR_NULL_HANDLE;
  if (const XrResult result = xrCreateReferenceSpace(session, &info, &space); XR_FAILED(result))
    return failed("xrCreateReferenceSpace", result);
  return space;
}

}  // namespace

Expected<std::unique_ptr<OpenXrSession>> OpenXrSession::open(const OpenXrInstance& instance,
                                                             std::shared_ptr<render::Context> context,
                                                             SharedState& shared) {
  if (auto asked = instance.require_opengl(); !asked) return tl::unexpected(asked.error());
  const render::Context::Native native = context->native();
  XrGraphicsBindingEGLMNDX binding{};
  binding.type = XR_TYPE_GRAPHICS_BINDING_EGL_MNDX;
  binding.getProcAddress = eglGetProcAddress;
  binding.display = native.display;
  binding.config = native.config;
  binding.context = native.context;
  XrSessionCreateInfo info{};
  info.type = XR_TYPE_SESSION_CREATE_INFO;
  info.next = &binding;
  info.systemId = instance.system();
  std::unique_ptr<OpenXrSession> opened(new OpenXrSession(instance, std::move(context), shared));
  if (const XrResult result = xrCreateSession(instance.handle(), &info, &opened->session_);
      XR_FAILED(result)) {
    opened->session_ = XR_NULL_HANDLE;
    return failed("xrCreateSession", result);
  }
  opened->context_->make_current();  // the runtime may have made another one current
  if (auto there = look_for_format(opened->session_); !there) return tl::unexpected(there.error());
  if (auto made = opened->make_spaces(); !made) return tl::unexpected(made.error());
  if (auto chosen = opened->choose_blend_mode(); !chosen) return tl::unexpected(chosen.error());
  return opened;
}

OpenXrSession::~OpenXrSession() {
  if (session_ == XR_NULL_HANDLE) return;
  if (view_ != XR_NULL_HANDLE) xrDestroySpace(view_);
  if (local_ != XR_NULL_HANDLE) xrDestroySpace(local_);
  picture_.release();
  panel_.release();
  xrDestroySession(session_);
  context_->make_current();
}

Expected<void> OpenXrSession::make_spaces() {
  auto local = make_space(session_, XR_REFERENCE_SPACE_TYPE_LOCAL);
  if (!local) return tl::unexpected(local.error());
  local_ = *local;
  auto view = make_space(session_, XR_REFERENCE_SPACE_TYPE_VIEW);
  if (!view) return tl::unexpected(view.error());
  view_ = *view;
  return {};
}

// The finished picture has the world in it: opaque, where the headset can be.
Expected<void> OpenXrSession::choose_blend_mode() {
  std::vector<XrEnvironmentBlendMode> modes(8, XR_ENVIRONMENT_BLEND_MODE_OPAQUE);
  std::uint32_t count = 0;
  const XrResult result = xrEnumerateEnvironmentBlendModes(
      instance_.handle(), instance_.system(), XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
      static_cast<std::uint32_t>(modes.size()), &count, modes.data());
  if (XR_FAILED(result)) return failed("xrEnumerateEnvironmentBlendModes", result);
  modes.resize(count);
  for (const auto mode : modes)
    if (mode == XR_ENVIRONMENT_BLEND_MODE_OPAQUE) return {};
  if (!modes.empty()) blend_ = modes.front();
  return {};
}

Expected<void> OpenXrSession::listen() {
  while (true) {
    XrEventDataBuffer event{};
    event.type = XR_TYPE_EVENT_DATA_BUFFER;
    const XrResult result = xrPollEvent(instance_.handle(), &event);
    if (XR_FAILED(result)) return failed("xrPollEvent", result);
    if (result == XR_EVENT_UNAVAILABLE) return {};
    if (event.type == XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING)
      return failed("xrPollEvent", XR_ERROR_INSTANCE_LOST);
    if (event.type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) {
      if (auto done = follow(reinterpret_cast<const XrEventDataSessionStateChanged&>(event).state); !done)
        return done;
    } else if (event.type == XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING) {
      local_moved(reinterpret_cast<const XrEventDataReferenceSpaceChangePending&>(event));
    }
  }
}

Expected<void> OpenXrSession::follow(XrSessionState state) {
  if (state == XR_SESSION_STATE_READY) {
    XrSessionBeginInfo info{};
    info.type = XR_TYPE_SESSION_BEGIN_INFO;
    info.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
    if (const XrResult result = xrBeginSession(session_, &info); XR_FAILED(result))
      return failed("xrBeginSession", result);
    running_ = true;
  } else if (state == XR_SESSION_STATE_STOPPING) {
    if (const XrResult result = xrEndSession(session_); XR_FAILED(result))
      return failed("xrEndSession", result);
    running_ = false;
  } else if (state == XR_SESSION_STATE_EXITING || state == XR_SESSION_STATE_LOSS_PENDING) {
    return refused(ErrorCode::disconnected, "headset: the OpenXR runtime ({}) has ended the session",
                   instance_.runtime());
  }
  return {};
}

// Somebody has said that this is now "in front": what we show has to stay where it is.
void OpenXrSession::local_moved(const XrEventDataReferenceSpaceChangePending& change) {
  if (change.referenceSpaceType != XR_REFERENCE_SPACE_TYPE_LOCAL || change.poseValid != XR_TRUE) return;
  coming_change_ = {change.changeTime, from_xr<Local, Local>(change.poseInPreviousSpace)};
}

Pose<Local, Local> OpenXrSession::first_local_at(XrTime time) const {
  if (!coming_change_ || time < coming_change_->time) return X_first_local_;
  return X_first_local_ * coming_change_->X_before_after;
}

Expected<void> OpenXrSession::look_at_head(Instant<GraphicsClock> now, XrTime time) {
  X_first_local_ = first_local_at(time);
  if (coming_change_ && time >= coming_change_->time) coming_change_.reset();
  XrSpaceLocation location{};
  location.type = XR_TYPE_SPACE_LOCATION;
  if (const XrResult result = xrLocateSpace(view_, local_, time, &location); XR_FAILED(result))
    return failed("xrLocateSpace", result);
  if ((location.locationFlags & kPoseKnown) == kPoseKnown)
    shared_.history.add(now, X_first_local_ * from_xr<Local, View>(location.pose));
  return {};
}

Expected<void> OpenXrSession::take_what_is_handed_over(Instant<GraphicsClock> displayed) {
  std::unique_ptr<HandedPicture> picture;
  std::unique_ptr<HandedPanel> panel;
  {
    const std::lock_guard lock(shared_.mutex);
    picture = std::move(shared_.picture);
    panel = std::move(shared_.panel);
  }
  if (panel) {
    panel_shown_ = panel->pixels.width > 0;
    panel_wide_ = panel->wide;
    panel_middle_ = panel->middle;
    if (panel_shown_)
      if (auto done = panel_.upload(session_, panel->pixels, GL_RGBA); !done) return done;
  }
  return picture ? take_picture(std::move(picture), displayed) : Expected<void>{};
}

Expected<void> OpenXrSession::take_picture(std::unique_ptr<HandedPicture> handed,
                                           Instant<GraphicsClock> displayed) {
  if (auto done = picture_.upload(session_, handed->pixels, GL_RGB); !done) return done;
  distance_ = handed->distance;
  const auto head = shared_.history.at(handed->image_time + shared_.settings.pose_delay);
  X_first_view_.reset();
  if (head.usable()) X_first_view_ = head.X_local_view;
  const std::lock_guard lock(shared_.mutex);
  ++shared_.facts.pictures_shown;
  shared_.facts.unplaced += head.usable() ? 0 : 1;
  shared_.shown = {handed->number, handed->image_time, displayed};
  if (!shared_.spare_picture) shared_.spare_picture = std::move(handed);
  return {};
}

void OpenXrSession::add_layers(XrTime displayed) {
  XrCompositionLayerQuad quad{};
  quad.type = XR_TYPE_COMPOSITION_LAYER_QUAD;
  const auto& eyes = shared_.settings.eyes;
  if (picture_.holds_picture()) {
    const int width = picture_.width() / static_cast<int>(eyes.size());
    for (std::size_t i = 0; i < eyes.size(); ++i) {
      const PictureQuad place = picture_quad(eyes[i].camera, distance_);
      const Pose<View, Panel> X_view_panel = eyes[i].X_view_camera * place.X_camera_panel;
      quad.space = X_first_view_ ? local_ : view_;
      quad.pose = X_first_view_ ? to_xr(first_local_at(displayed).inverse() * *X_first_view_ * X_view_panel)
                                : to_xr(X_view_panel);
      quad.eyeVisibility = eyes.size() == 1 ? XR_EYE_VISIBILITY_BOTH
                           : i == 0         ? XR_EYE_VISIBILITY_LEFT
                                            : XR_EYE_VISIBILITY_RIGHT;
      quad.subImage = picture_.part(static_cast<int>(i) * width, width);
      quad.size = {static_cast<float>(place.width), static_cast<float>(place.height)};
      layers_.push_back(quad);
    }
  }
  if (panel_shown_ && panel_.holds_picture()) {
    quad.layerFlags = XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT;
    quad.space = view_;
    quad.pose = to_xr(Quaternion::Identity(), panel_middle_);
    quad.eyeVisibility = XR_EYE_VISIBILITY_BOTH;
    quad.subImage = panel_.part(0, panel_.width());
    quad.size = {static_cast<float>(panel_wide_),
                 static_cast<float>(panel_wide_ * panel_.height() / panel_.width())};
    layers_.push_back(quad);
  }
}

Expected<void> OpenXrSession::frame() {
  XrFrameState asked{};
  asked.type = XR_TYPE_FRAME_STATE;
  if (const XrResult result = xrWaitFrame(session_, nullptr, &asked); XR_FAILED(result))
    return failed("xrWaitFrame", result);
  if (const XrResult result = xrBeginFrame(session_, nullptr); XR_FAILED(result))
    return failed("xrBeginFrame", result);
  const std::int64_t monotonic = shared_.settings.monotonic_ns();
  auto time = instance_.time_of(monotonic);
  if (!time) return tl::unexpected(time.error());
  auto displayed = instance_.monotonic_of(asked.predictedDisplayTime);
  if (!displayed) return tl::unexpected(displayed.error());
  const MonotonicClock<GraphicsClock>& clock = shared_.settings.clock;
  const DisplayTimes display{clock.from_monotonic(monotonic), clock.from_monotonic(*displayed),
                             Duration(asked.predictedDisplayPeriod)};
  if (auto done = look_at_head(display.begun, *time); !done) return done;
  if (auto done = take_what_is_handed_over(display.displayed); !done) return done;
  layers_.clear();
  if (asked.shouldRender == XR_TRUE) add_layers(asked.predictedDisplayTime);
  std::vector<const XrCompositionLayerBaseHeader*> headers;
  for (const auto& layer : layers_)
    headers.push_back(reinterpret_cast<const XrCompositionLayerBaseHeader*>(&layer));
  XrFrameEndInfo end{};
  end.type = XR_TYPE_FRAME_END_INFO;
  end.displayTime = asked.predictedDisplayTime;
  end.environmentBlendMode = blend_;
  end.layerCount = static_cast<std::uint32_t>(headers.size());
  end.layers = headers.data();
  if (const XrResult result = xrEndFrame(session_, &end); XR_FAILED(result))
    return failed("xrEndFrame", result);
  count_frame(display);
  return {};
}

void OpenXrSession::count_frame(const DisplayTimes& display) {
  const std::lock_guard lock(shared_.mutex);
  ++shared_.facts.frames;
  shared_.facts.with_picture += !layers_.empty() && picture_.holds_picture() ? 1 : 0;
  shared_.facts.display = display;
  shared_.facts.state = HeadsetState::showing;
}

}  // namespace palpate::headset
